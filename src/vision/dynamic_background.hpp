// SPDX-License-Identifier: Apache-2.0
// What moves in place and is no body: leaves in the wind, water, a flag.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace choreo::vision {

/// A picture whose colours are searched for near where they are shown elsewhere: up to a fortieth of the height away, 3
/// to 8 pixels.
class SurroundedColours {
 public:
  explicit SurroundedColours(const cv::Mat& picture);  ///< CV_8UC3, copied.
  /// Whether `colour` is about `at`, which itself does not count.
  /// @param threshold  grey levels of D up to which two colours are one.
  /// @cost  O(reach^2) at worst; where leaves move, a few steps, and none where no colour about is alike.
  [[nodiscard]] bool show(const cv::Vec3b& colour, cv::Point at, double threshold) const;

 private:
  static constexpr int kSquare = 8;  // No less than the reach.

  int reach_;
  cv::Mat wider_;                      // By the reach at every side.
  std::vector<std::ptrdiff_t> steps_;  // Bytes in it, the nearest first.
  cv::Mat lowest_, highest_;           // CV_8UC3, a pixel a square: bounds of the colours of it and of those about it.
};

/// Those pixels of `mask` that show what `wall` shows some pixels farther on.
/// @param mask  CV_8UC1, 0 or 255.  @param picture, wall  CV_8UC3, of its size.
/// @return CV_8UC1, 0 or 255.
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
  /// @cost  For each of the mask's pixels in the area a search in up to 25 pictures, mostly in about ten.
  [[nodiscard]] cv::Mat without(const cv::Mat& mask, const cv::Mat& picture, const cv::Mat& background,
                                double threshold) const;

 private:
  cv::Mat area_;
  std::vector<SurroundedColours> looks_;
};

}  // namespace choreo::vision
