// SPDX-License-Identifier: Apache-2.0
// What a depth camera of the Kinect's kind sees of the performer and the room.
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core.hpp>

#include "body/figure.hpp"
#include "devices/synthetic/look.hpp"
#include "devices/synthetic/room.hpp"

namespace choreo::devices::synthetic {

/// Depth by structured light, registered to the colour picture pixel on pixel.
///
/// The wall is a plane about 3.5 m away, askew; the floor runs from its foot to under the performer, who stands 2.5 m
/// away and is as round as `body::ellipsoids_of`. Noise grows with z^2 (2 mm at 2 m), values are whole steps of
/// disparity (an eighth of a pixel, focal length 580 px, baseline 75 mm: 18 mm at 2.5 m), what the projector cannot
/// reach beside a body is 0, and so are one pixel in 200 and one in four along edges; as many there belong to the wrong
/// side.
/// @thread reentrant
class DepthCamera {
 public:
  DepthCamera(const Stage& stage, const Look& look, std::uint64_t seed);

  /// @param index  of the frame: chance depends on it, the pixel and the seed alone.
  /// @param body   CV_8UC1 of the stage's size, not 0 where the body is; empty where nobody is there.
  /// @param pose   of that body.
  /// @param shift  pixels by which the camera displaces everything.
  /// @return CV_16UC1, millimetres from the camera's plane, 0 where nothing is known.
  [[nodiscard]] cv::Mat film(int index, const cv::Mat& body, const body::Pose& pose, cv::Point2d shift) const;

 private:
  [[nodiscard]] cv::Mat1f room(cv::Point2d shift) const;
  void place(cv::Mat1f& depth, const cv::Mat& body, const body::Pose& pose, cv::Point2d shift) const;

  Stage stage_;
  body::Build build_;
  std::uint64_t seed_;
  std::vector<float> noise_;  // Normal numbers; a power of two of them.
};

}  // namespace choreo::devices::synthetic
