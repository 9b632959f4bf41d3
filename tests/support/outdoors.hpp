// SPDX-License-Identifier: Apache-2.0
// Drawn scenes out of doors without a dancer: leaves in the wind that somebody passes, and a road.
#pragma once

#include <span>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace choreo::test {

inline constexpr int kOutdoorsFps = 15;
inline const cv::Size kOutdoorsSize(160, 120);
/// Where leaves are in the garden.
inline const cv::Rect kTree(70, 0, 90, 80);

struct Scene {
  std::vector<cv::Mat> pictures;  ///< CV_8UC3, 15 a second.
  std::vector<cv::Mat> truths;    ///< CV_8UC1: 255 what passes, 0 the rest, 128 its shadow, which counts for nothing.
};

/// Somebody in a red shirt crosses a garden from the sixth second on, before a wall and before leaves of two greens,
/// each bough of which sways in its own time by up to `sway_px`.
[[nodiscard]] Scene garden(double sway_px, double seconds);

/// Cars of many colours on two lanes, each with its shadow, one every second and a half on either; a tree beside them
/// sways by two pixels.
[[nodiscard]] Scene road(double seconds);

/// 2 TP / (2 TP + FP + FN) over all pixels of all pictures, shadows left out.
[[nodiscard]] double f_measure(std::span<const cv::Mat> masks, std::span<const cv::Mat> truths);

}  // namespace choreo::test
