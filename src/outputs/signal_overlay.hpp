// SPDX-License-Identifier: Apache-2.0
// What is read of a signaller, drawn over the picture: the letter large, the text so far, the face and the arms.
#pragma once

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace choreo::outputs {

/// An ellipse in pixels of the picture.
struct Ring {
  cv::Point2d centre;
  cv::Size2d half;       ///< Half axes, before turning.
  double angle_deg = 0;  ///< From the x axis towards the y axis, which points down.
};

/// A region with these second central moments over its area, as an ellipse that has them, too.
/// @param cov_xx, cov_xy, cov_yy  px squared, y down; cov_xx cov_yy >= cov_xy^2.
[[nodiscard]] Ring ring_of(cv::Point2d centroid, double cov_xx, double cov_xy, double cov_yy);

struct SignalOverlay {
  std::string letter{};       ///< Large, in the lower left; a word such as NUMERALS is made to fit. Empty: none.
  std::string beside{};       ///< Small, above the letter: how sure, and what else it may be.
  std::string text{};         ///< Along the lower edge; of a long one its end.
  std::vector<Ring> faces{};  ///< Thin, in white.
  std::vector<Ring> arms{};   ///< In the letter's colour.
};

/// A copy of the picture with the overlay, in type that can be read across a stage.
/// @param picture  CV_8UC3.
[[nodiscard]] cv::Mat drawn_over(const cv::Mat& picture, const SignalOverlay& overlay);

}  // namespace choreo::outputs
