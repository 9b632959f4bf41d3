// SPDX-License-Identifier: Apache-2.0
// What a look at a person tells.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include "vision/face.hpp"

namespace choreo::vision {

/// A square part of a picture, turned so that the person in it stands upright.
struct PersonRegion {
  cv::Point2d centre;  ///< In pixels; the middle of the first pixel is (0, 0).
  double side = 0;     ///< In pixels.
  double angle = 0;    ///< How far the person leans to the right of the picture's upright, in radians.

  /// Takes a place in the picture to one in the region, which is a picture of `size` x `size`.
  [[nodiscard]] cv::Matx23d from_picture(int size) const;
  /// The same part of the mirror image of a picture of that width.
  [[nodiscard]] PersonRegion flipped(int width) const { return {{width - 1 - centre.x, centre.y}, side, -angle}; }
  friend bool operator==(const PersonRegion&, const PersonRegion&) = default;
};

/// The points of MediaPipe's pose models by their numbers; left and right are the person's own.
enum class PersonPointName : std::size_t {
  kNose = 0,
  kLeftEye = 2,
  kRightEye = 5,
  kLeftEar = 7,
  kRightEar = 8,
  kMouthLeft = 9,
  kMouthRight = 10,
  kLeftShoulder = 11,
  kRightShoulder = 12,
  kLeftElbow = 13,
  kRightElbow = 14,
  kLeftWrist = 15,
  kRightWrist = 16,
  kLeftHip = 23,
  kRightHip = 24,
  kLeftKnee = 25,
  kRightKnee = 26,
  kLeftAnkle = 27,
  kRightAnkle = 28,
};
inline constexpr std::size_t kPersonPoints = 33;
inline constexpr std::array<const char*, kPersonPoints> kPersonPointNames = {
    "nose",        "left_eye_inner",  "left_eye",        "left_eye_outer", "right_eye_inner",
    "right_eye",   "right_eye_outer", "left_ear",        "right_ear",      "mouth_left",
    "mouth_right", "left_shoulder",   "right_shoulder",  "left_elbow",     "right_elbow",
    "left_wrist",  "right_wrist",     "left_pinky",      "right_pinky",    "left_index",
    "right_index", "left_thumb",      "right_thumb",     "left_hip",       "right_hip",
    "left_knee",   "right_knee",      "left_ankle",      "right_ankle",    "left_heel",
    "right_heel",  "left_foot_index", "right_foot_index"};

struct PersonPoint {
  cv::Point2d at;         ///< In pixels of the picture.
  double depth = 0;       ///< Towards the camera is less; about in pixels, from the hips.
  double visibility = 0;  ///< How likely nothing hides it, 0 to 1.
  double presence = 0;    ///< How likely it is in the picture, 0 to 1.
};

struct PersonLook {
  double score = 0;  ///< How likely a person is there, 0 to 1.
  std::array<PersonPoint, kPersonPoints> points{};
  std::array<cv::Point3d, kPersonPoints> metres{};  ///< From the middle of the hips: right, down, away from the camera.
  PersonRegion region;                              ///< Where was looked.
  PersonRegion next;                                ///< Where to look in the next picture.
  cv::Mat silhouette;  ///< CV_8UC1, square, of `region`: how likely a pixel is the person's, 0 to 255.

  [[nodiscard]] const PersonPoint& operator[](PersonPointName name) const {
    return points[static_cast<std::size_t>(name)];
  }
  /// By how far apart the joints are in the picture and in space; 0 where all are in one place.
  [[nodiscard]] double pixels_per_metre() const;
  /// Whether the head shows its back: the nose lies more than 110 degrees off the way to the camera, as seen from above
  /// between the ears. Points of a face that is away count as seen all the same.
  [[nodiscard]] bool faces_away() const;
};

/// The silhouette in a picture of that size: CV_8UC1, 0 to 255; 0 outside of the region.
[[nodiscard]] cv::Mat silhouette_in_picture(const PersonLook& look, cv::Size size);

/// The person's face as FaceDetectors give it: between eyes and mouth, a tenth of a person's height wide. Nothing where
/// these are not seen, or away.
[[nodiscard]] std::optional<Face> face_of(const PersonLook& look);

}  // namespace choreo::vision
