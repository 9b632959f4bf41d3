// SPDX-License-Identifier: Apache-2.0
// The wall behind the body, from pictures in which a body may stand before it.
#pragma once

#include <span>

#include <opencv2/core/mat.hpp>

#include "vision/camera_motion.hpp"
#include "vision/dynamic_background.hpp"

namespace choreo::vision {

/// A picture of the room without the body, and how far it can be trusted.
struct BackgroundEstimate {
  cv::Mat plate;  ///< CV_8UC3.
  /// Standard deviation of the sensor's noise in D (`difference_luminance` against the plate), in grey levels.
  double noise = 0;
  /// Mean share of a body's filled silhouette at which the wall was never seen for certain, over the pictures with a
  /// body; 0 to 1.
  double unseen = 0;
  /// Share of the pictures that show no body, 0 to 1.
  double empty = 0;
  /// CV_8UC1, 255 where somebody stood in every picture, so that the plate is a guess; empty: not known.
  cv::Mat never_seen;
  CameraKind camera = CameraKind::kStill;  ///< The plate shows the room from where one of the pictures was taken.
  DynamicBackground dynamic;               ///< Where the room moves in place.

  /// Whether masks made against it may have holes or ghosts.
  [[nodiscard]] bool uncertain() const { return unseen > 0.02; }
};

/// Per pixel and channel the median over the pictures: right where more than half of them show the wall.
/// @param pictures  at least one, CV_8UC3, of one size.
[[nodiscard]] cv::Mat median_plate(std::span<const cv::Mat> pictures);

/// Of a clip's beginning: the median, and where a stretch in which the whole picture stood still has the weaker
/// outline, that stretch. Somebody who comes in halfway is in half of the pictures.
/// @param pictures, quiet  as of `estimate_background`.
[[nodiscard]] BackgroundEstimate estimate_beginning(std::span<const cv::Mat> pictures, std::span<const cv::Mat> quiet);

/// A robust estimate over a whole clip: people move, walls do not.
///
/// Per pixel the colours seen are clustered and the commonest cluster is taken. Stretches in which the whole picture
/// stands still are candidates for the empty room: where such a stretch and the commonest colours disagree over a
/// region, the one without an edge along the region's border is the wall, since a body has an outline and a wall goes
/// on behind it.
/// All are brought to one light first: cameras change exposure as somebody walks in.
/// @param pictures  evenly spread over the clip; at least one, CV_8UC3, of one size.
/// @param quiet  means of stretches in which the picture stood still (`QuietStretches`), the longest first.
/// @cost  O(pictures x pixels); uses all cores, and the result does not depend on how many.
[[nodiscard]] BackgroundEstimate estimate_background(std::span<const cv::Mat> pictures, std::span<const cv::Mat> quiet);

/// The noise of a BackgroundEstimate with that plate.
/// @param pictures  at least one, CV_8UC3, of the plate's size.
[[nodiscard]] double noise_before(const cv::Mat& plate, std::span<const cv::Mat> pictures);

/// A given plate judged against pictures of the clip: fills in noise, unseen and empty.
[[nodiscard]] BackgroundEstimate judge_plate(const cv::Mat& plate, std::span<const cv::Mat> pictures);

}  // namespace choreo::vision
