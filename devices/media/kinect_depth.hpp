// SPDX-License-Identifier: Apache-2.0
// What the first Kinect's depth words mean, and where its depth lies in its colour picture.
#pragma once

#include <cstdint>
#include <span>

#include <opencv2/core/mat.hpp>

namespace choreo::devices {

inline const cv::Size kKinectSize{640, 480};
inline constexpr double kKinectFps = 30;
inline constexpr std::uint16_t kNoKinectWord = 2047;
inline constexpr int kNearestKinectMm = 400;  ///< Nearer or farther than these the sensor tells nothing that holds.
inline constexpr int kFarthestKinectMm = 10000;

/// The distance from the camera's plane that a word of 11 bits stands for.
///
/// With x = ((word - 4 * 200) / 4 - 0.375) * 0.1042 mm, the shift of the dot pattern on the zero plane:
///   z = 10 * (120 * x / (7.5 - x) + 120), truncated to whole millimetres.
///
/// @return millimetres from `kNearestKinectMm` to `kFarthestKinectMm`; 0 for 2047, for what lies outside and for words
///   of more than 11 bits.
/// @source libfreenect 0.5.3, registration.c, freenect_raw_to_mm, with the nominal zero plane of its
///   freenect_init_registration (emitter 7.5 cm beside the camera, plane at 120 cm, pixel 0.1042 mm, shift 200). A
///   device has a plane of its own; with this one a recording means the same everywhere.
[[nodiscard]] std::uint16_t kinect_millimetres(std::uint16_t word);

/// The word whose distance is nearest to `mm`, of two the nearer; 2047 where `mm` is 0 or out of range. The inverse of
/// `kinect_millimetres` as far as there is one: far away, a word stands for more than 100 mm.
[[nodiscard]] std::uint16_t kinect_word(std::uint16_t mm);

/// @param words  of the size's pixels, line by line, 16 bits each, the low byte first.
/// @return CV_16UC1, millimetres, 0 where nothing is known.
/// @throws Error (failure) where the number of bytes is not the size's.
[[nodiscard]] cv::Mat kinect_depth(std::span<const std::uint8_t> words, cv::Size size = kKinectSize);

/// The depth as the colour camera sees it: pixel on pixel with the colour picture.
///
/// A pixel (u, v) at z becomes u' = (u - 319.5) * 525 / 580 - 525 * 25 / z + 319.5, v' = (v - 239.5) * 525 / 580 +
/// 239.5, rounded. Of several the nearest stays; what nothing falls on is 0, also the border that only the colour
/// camera sees. These are the nominal lenses (focal lengths 580 and 525 pixels; the colour camera 25 mm to the right),
/// without distortion: some pixels off. A device that registers by itself knows its own lenses and does better.
///
/// @param depth_mm  CV_16UC1, 640 x 480, as the depth camera sees it.
/// @throws Error (failure) on another size or type.
[[nodiscard]] cv::Mat kinect_registered(const cv::Mat& depth_mm);

}  // namespace choreo::devices
