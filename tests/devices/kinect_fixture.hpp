// SPDX-License-Identifier: Apache-2.0
// Pictures that a Kinect could have seen, each one different, and dumps of them.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <opencv2/core.hpp>

#include "devices/media/kinect_depth.hpp"
#include "outputs/kinect_dump_writer.hpp"
#include "support/frames.hpp"

namespace choreo::test {

inline constexpr Nanoseconds kKinectPeriod{33'333'333};

inline cv::Mat kinect_colour(int k) {
  return noise(devices::kKinectSize, CV_8UC3, static_cast<std::uint64_t>(1000 + k));
}

/// Words of 11 bits of every kind, among them 2047.
inline std::vector<std::uint8_t> kinect_words(int k) {
  cv::Mat words(devices::kKinectSize, CV_16UC1);
  cv::RNG random(static_cast<std::uint64_t>(2000 + k));
  random.fill(words, cv::RNG::UNIFORM, 0, 2048);
  return {words.data, words.data + words.total() * words.elemSize()};
}

/// A number that tells pictures apart, in whichever process; 0 of an empty one. Left to libraries, as the pictures are:
/// with sanitizers a loop over the bytes takes longer than a frame.
inline std::uint64_t fingerprint(const cv::Mat& picture) {
  if (picture.empty()) return 0;
  const cv::Mat whole = picture.isContinuous() ? picture : picture.clone();
  return std::hash<std::string_view>()({whole.ptr<char>(), whole.total() * whole.elemSize()});
}

/// Frame k has its colour at `begin` + k periods and its depth `depth_late` after it.
inline void write_kinect_dump(const std::string& folder, int frames, Nanoseconds begin = std::chrono::seconds(100),
                              Nanoseconds depth_late = std::chrono::milliseconds(4)) {
  outputs::KinectDumpWriter writer(folder);
  for (int k = 0; k < frames; ++k) {
    writer.write_colour(kinect_colour(k), begin + k * kKinectPeriod);
    writer.write_words(kinect_words(k), begin + k * kKinectPeriod + depth_late);
  }
}

}  // namespace choreo::test
