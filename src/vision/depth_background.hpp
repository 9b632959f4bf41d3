// SPDX-License-Identifier: Apache-2.0
// How far away the empty room is, from depth pictures in which a body may stand before it.
#pragma once

#include <algorithm>
#include <span>

#include <opencv2/core/mat.hpp>

namespace choreo::vision {

/// How much nearer than the room a pixel must be to be body: max(least_mm, factor * spread).
struct DepthMargin {
  double factor = 4.0;
  double least_mm = 25.0;

  [[nodiscard]] float of(float spread_mm) const {
    return static_cast<float>(std::max(least_mm, factor * double(spread_mm)));
  }
};

/// The room without the body, and how surely each pixel of it is measured.
struct DepthBackground {
  cv::Mat depth_mm;   ///< CV_16UC1, 0 where the room's depth is unknown.
  cv::Mat spread_mm;  ///< CV_32FC1, standard deviation of a reading; at least the sensor's own at that depth.
  /// CV_8UC1, 255 where a body stood in every picture and the depth is that of the room beside it; empty: nowhere.
  cv::Mat inferred;
  /// The sensor's own deviation is this times z^2, 1/mm: the median over the pixels.
  double noise_per_mm = 0;
  double empty = 0;  ///< Share of the pictures that show no body, 0 to 1.

  [[nodiscard]] double known_share() const;     ///< Of the pixels, 0 to 1.
  [[nodiscard]] double inferred_share() const;  ///< Likewise.
};

/// Per pixel the farthest depth that was seen often enough: a body can only be nearer than the room.
///
/// Valid readings (not 0), sorted, fall into runs whose neighbours are at most max(30 mm, 6e-6 z^2 / mm) apart, twice a
/// Kinect's step. The farthest run with at least a twentieth of the pictures' readings is the room: its median and
/// standard deviation; where no run has so many, and so many readings are valid, the largest run. Where fewer are, the
/// depth is unknown.
///
/// Somebody who never leaves is there in every reading of some pixels. What stands at least 150 mm before the room to
/// its left and right, and in a quarter of the pictures goes on in what moves, is that body: there the nearer of both
/// sides is taken (`inferred`). Where a twentieth of the pictures or more show nothing that moves, so that somebody may
/// have left and a piece of furniture stayed, it must go on in what moves in nine tenths of the others; where half of
/// them do, nothing is inferred.
/// @param pictures  at least one, CV_16UC1, millimetres, of one size.
/// @cost  O(pictures x pixels); uses all cores, and the result does not depend on how many.
[[nodiscard]] DepthBackground learn_depth_background(std::span<const cv::Mat> pictures, const DepthMargin& margin = {});

/// What is nearer than the room by more than the margin, in a picture of it; 255 or 0.
/// @param depth_mm  CV_16UC1 of the background's size.  @return CV_8UC1.
[[nodiscard]] cv::Mat nearer_than(const DepthBackground& room, const cv::Mat& depth_mm, const DepthMargin& margin);

}  // namespace choreo::vision
