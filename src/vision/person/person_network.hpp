// SPDX-License-Identifier: Apache-2.0
// Looks for a person's joints and silhouette by MediaPipe's pose models.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "vision/network/network.hpp"
#include "vision/person/person.hpp"

namespace choreo::vision {

/// Finds joints and silhouette of a person of whom it is known about where they are.
/// @source Bazarevsky et al., BlazePose: On-device Real-time Body Pose Tracking, 2020; the models' card of 2021 for the
///   silhouette.
/// @thread thread-bound
class PersonNetwork {
 public:
  /// @param model  pose_landmark_lite.tflite or pose_landmark_full.tflite.
  /// @throws Error (usage) where it is neither.
  explicit PersonNetwork(std::span<const std::uint8_t> model);

  /// @param picture  CV_8UC3, not empty.
  /// @param region  with a side of at least a pixel (asserted); it may reach out of the picture, where all is black.
  [[nodiscard]] PersonLook look(const cv::Mat& picture, const PersonRegion& region);

 private:
  Network network_;
  std::size_t points_ = 0, score_ = 0, silhouette_ = 0, metres_ = 0;  // Numbers of outputs.
};

/// Somebody who was found.
struct DetectedPerson {
  PersonRegion region;  ///< For PersonNetwork.
  cv::Rect2d box;       ///< Of the upper body.
  double score = 0;     ///< 0.5 to 1.
};

/// Finds people in a whole picture, who are at least a tenth of its height or so.
/// @source the same paper, 3.1: a face detector's anchors, from which hips and size of the body are told.
/// @thread thread-bound
class PersonDetector {
 public:
  /// @param model  pose_detection.tflite.  @throws Error (usage) where it is another.
  explicit PersonDetector(std::span<const std::uint8_t> model);

  /// @param picture  CV_8UC3, not empty.
  /// @return everybody, the surest first.
  [[nodiscard]] std::vector<DetectedPerson> detect(const cv::Mat& picture);

 private:
  Network network_;
  std::size_t boxes_ = 0, scores_ = 0;  // Numbers of outputs.
  std::vector<cv::Point2d> anchors_;    // 0 to 1.
};

/// A region from the middle of the hips and a point as far above it as the body reaches.
[[nodiscard]] PersonRegion region_of(cv::Point2d hips, cv::Point2d reach);

}  // namespace choreo::vision
