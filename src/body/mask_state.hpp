// SPDX-License-Identifier: Apache-2.0
// The body's silhouette as a state: bits around its centroid.
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "body/body_state.hpp"

namespace choreo::body {

/// A silhouette in coordinates relative to the whole pixel nearest its centroid, on a canvas without bounds.
///
/// With M pixels, c = (sum x / M, sum y / M) and C = floor(c + 1/2) per axis, a body pixel at (x, y) has the relative
/// coordinates u = (x, y) - C. `remainder_x` = sum x - C_x M keeps the part of the centroid that C loses, in integers:
/// f = c_x - C_x = remainder_x / M in [-1/2, 1/2).
/// @source Performance Physics, 4.2, with the mirror's half-pixel corrected (docs/mathematics.md).
class MaskState {
 public:
  /// @param mask CV_8UC1, body where not 0; at least one body pixel (asserted).
  /// @cost O(pixels), one allocation.
  explicit MaskState(const cv::Mat& mask);

  [[nodiscard]] std::int64_t area() const { return area_; }                ///< Body pixels, M.
  [[nodiscard]] std::int64_t remainder_x() const { return remainder_x_; }  ///< sum x - C_x M, in [-M/2, M/2).
  [[nodiscard]] cv::Rect box() const { return box_; }  ///< Smallest rectangle with all body pixels, relative to C.
  [[nodiscard]] cv::Point center() const { return center_; }        ///< C, in pixels of the picture.
  [[nodiscard]] cv::Point2d centroid() const { return centroid_; }  ///< c, in pixels of the picture.

  /// Whether the pixel at relative coordinates (x, y) is body; false everywhere outside `box()`.
  [[nodiscard]] bool at(int x, int y) const;

  /// Row `y` (relative to C, within `box()`): bit k of the words is the pixel at x = box().x + k. Bits past the box
  /// are 0.
  [[nodiscard]] const std::uint64_t* row(int y) const { return words_.data() + std::size_t(y - box_.y) * row_words_; }
  [[nodiscard]] std::size_t row_words() const { return row_words_; }

  friend MaskState mirrored(const MaskState& a);

 private:
  MaskState() = default;
  void set(int x, int y);

  std::int64_t area_ = 0;
  std::int64_t remainder_x_ = 0;
  cv::Rect box_;
  cv::Point center_;
  cv::Point2d centroid_;
  std::size_t row_words_ = 0;
  std::vector<std::uint64_t> words_;
};

/// The silhouette seen in a mirror through its own center: what the camera would see of the mirrored body, up to where
/// it stands. Twice gives the same state, center included.
[[nodiscard]] MaskState mirrored(const MaskState& a);

/// The whole-pixel shift between b and the mirror image of a: floor(f_a + f_b + 1/2) in {-1, 0, 1}, in integers.
[[nodiscard]] int mirror_shift(std::int64_t remainder_a, std::int64_t area_a, std::int64_t remainder_b,
                               std::int64_t area_b);

/// Z(a, b) = |a and b| / sqrt(|a| |b|), from the pixels in common. The one place where counts become similarities.
[[nodiscard]] double similarity_of_counts(std::int64_t common, std::int64_t area_a, std::int64_t area_b);

/// Z(a, b) = sum_u A(u) B(u) / sqrt(|A| |B|). The specification of the fast kernels; bit by bit.
[[nodiscard]] double similarity(const MaskState& a, const MaskState& b);

/// Z*(a, b) = sum_u A(sigma - u_x, u_y) B(u) / sqrt(|A| |B|), sigma = mirror_shift. Likewise.
[[nodiscard]] double mirror_similarity(const MaskState& a, const MaskState& b);

static_assert(BodyState<MaskState>);

}  // namespace choreo::body
