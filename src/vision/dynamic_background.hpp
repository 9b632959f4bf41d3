// SPDX-License-Identifier: Apache-2.0
// What moves in place and is no body: leaves in the wind, water, a flag.
#pragma once

#include <span>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace choreo::vision {

/// Those pixels of `mask` that show what `wall` shows some pixels farther on: up to a fortieth of the height, 3 to 8.
/// @param mask  CV_8UC1, 0 or 255.  @param picture, wall  CV_8UC3, of its size.
/// @param threshold  grey levels of D up to which two colours are one.
/// @return CV_8UC1, 0 or 255.
/// @cost  O(pixels of `mask` x reach^2) at worst; where leaves move, a few steps a pixel.
[[nodiscard]] cv::Mat displaced(const cv::Mat& mask, const cv::Mat& picture, const cv::Mat& wall, double threshold);

/// The part of a room that moves in place, and what it looks like.
///
/// It is where in a quarter of the pictures the wall is displaced, all about, and comes and goes from picture to
/// picture. There a difference counts only where its colour was not about there before: neither in the background nor
/// in a third of some pictures that are kept. Where something stayed for several pictures on end it was somebody, and
/// counts.
class DynamicBackground {
 public:
  DynamicBackground() = default;  ///< A room that stands still.
  /// @param pictures, backgrounds  CV_8UC3, of one size, as many, at least one; each background in the light of its
  ///   picture.
  DynamicBackground(std::span<const cv::Mat> pictures, std::span<const cv::Mat> backgrounds, double threshold);

  /// CV_8UC1, 255 where the room moves; empty: nowhere.
  [[nodiscard]] const cv::Mat& area() const { return area_; }
  [[nodiscard]] double share() const;  ///< Of the picture, [0, 1].
  /// `mask` without what the room did before. Arguments as of `displaced`.
  /// @cost  Of the mask's pixels in the area whose colour was ever about: that of `displaced` for each of some looks.
  [[nodiscard]] cv::Mat without(const cv::Mat& mask, const cv::Mat& picture, const cv::Mat& background,
                                double threshold) const;

 private:
  cv::Mat area_;
  cv::Mat lowest_, highest_;    // CV_8UC3: between these are all colours about each pixel.
  std::vector<cv::Mat> looks_;  // CV_8UC3.
};

}  // namespace choreo::vision
