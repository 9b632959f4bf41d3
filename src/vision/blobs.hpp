// SPDX-License-Identifier: Apache-2.0
// From a mask to its connected regions with their moments.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "vision/blob.hpp"
#include "vision/runs.hpp"

namespace choreo::vision {

/// Longest side of a picture whose third moments fit 64 bits.
inline constexpr int kLongestSide = 4096;

/// Adds up x^p y^q over pixels to third order, in integers: exact, whatever the order.
class RawMoments {
 public:
  /// @param run  coordinates from 0 to kLongestSide - 1 (asserted).
  /// @cost O(1).
  void add(const Run& run);
  void add(const RawMoments& other);

  [[nodiscard]] std::int64_t area() const { return m00_; }

  /// The central moments. The sums are shifted to the whole pixel nearest the centroid in integers, and by its
  /// remainder, at most half a pixel, in double: nothing large cancels. All 0 where nothing was added.
  [[nodiscard]] Moments central() const;

 private:
  std::int64_t m00_ = 0;
  std::int64_t m10_ = 0, m01_ = 0;
  std::int64_t m20_ = 0, m11_ = 0, m02_ = 0;
  std::int64_t m30_ = 0, m21_ = 0, m12_ = 0, m03_ = 0;
};

/// The moments of all pixels that are not 0.
/// @param mask  CV_8UC1, no side longer than kLongestSide.
[[nodiscard]] Moments moments_of(const cv::Mat& mask);

/// The moments of two regions without a common pixel as one: both are moved to their common centroid and added.
/// mu20 = mu20' + mu20'' + m00' d'^2 + m00'' d''^2 and so on; for equal areas 2 a apart mu20' + mu20'' + 2 a^2 per
/// area.
[[nodiscard]] Moments together(const Moments& a, const Moments& b);

/// The connected regions of a mask.
struct Regions {
  std::vector<Blob> blobs;             ///< In reading order of their first pixels.
  std::vector<std::vector<Run>> runs;  ///< Of each blob, in reading order.
};

/// The connected components (8-neighbourhood) of at least `least_area` pixels.
/// @param mask  CV_8UC1, set where not 0; no side longer than kLongestSide.
/// @cost O(pixels); once over the picture.
[[nodiscard]] Regions regions_of(const cv::Mat& mask, int least_area = 1);

/// Sets the runs' pixels of a CV_8UC1 picture to `value`.
void paint(std::span<const Run> runs, std::uint8_t value, cv::Mat& picture);

}  // namespace choreo::vision
