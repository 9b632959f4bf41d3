// SPDX-License-Identifier: Apache-2.0
// The triangle of Z and Z* that scrolls while the rows come.
#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace choreo::similarity {

/// The last seconds of Z (red) and Z* (cyan) as a triangle: the identity axis is its base, now its right corner, the
/// lag goes upwards.
///
/// A pixel belongs to a mean time and a lag, and stays where it is as the picture scrolls: a row is drawn once, into
/// the pixels of the pairs it makes. Where frames lie closer than pixels, a pixel is the mean of its pairs; where they
/// lie wider, of the pairs whose frames were on at four points of it. Memory is fixed.
/// @thread thread-bound
class ScrollingTriangle {
 public:
  /// @param span_s  > 0, seconds across the base.  @param width_px  > 0, even.
  /// @param gap  the colour, BGR, of pairs of which a frame has no body.
  /// @param blank  the colour of what has not been.
  ScrollingTriangle(double span_s, int width_px, cv::Vec3b gap, cv::Vec3b blank);

  /// Takes the row of the newest frame.
  /// @param time_s  of that frame, increasing.
  /// @param z, zstar  against the newest frames of those given so far, oldest first, that frame last, in [0, 1] or NaN;
  ///   of one length, which may shrink and grow as the history does.
  void add_row(double time_s, std::span<const float> z, std::span<const float> zstar);

  /// The picture: CV_8UC3, width_px / 2 rows. The base is its lowest row and ends at the newest frame; what lies
  /// outside of the triangle is not blanked.
  [[nodiscard]] cv::Mat picture() const;

  [[nodiscard]] double span_s() const { return span_s_; }
  [[nodiscard]] int width_px() const { return width_; }

 private:
  struct Cell {
    float z = 0;
    float zstar = 0;
    std::uint32_t pairs = 0;
  };

  void scroll_to(double time_s);
  void add(std::int64_t column, int lag, float z, float zstar, bool provisional);
  template <typename Visit>
  void for_each_point(int fine, double before_s, Visit visit) const;
  void put_means(std::span<const float> z, std::span<const float> zstar);
  void put_provisional(double before_s, std::span<const float> z, std::span<const float> zstar);
  void put_samples(double before_s, std::span<const float> z, std::span<const float> zstar);

  double span_s_;
  int width_;
  int height_;
  double pitch_s_;          // Mean time across a pixel; a pixel is twice that high in lag.
  double last_step_s_ = 0;  // Between the last two frames.
  cv::Vec3b gap_;
  cv::Vec3b blank_;
  std::deque<double> times_s_;       // Of the frames within the span.
  std::vector<Cell> cells_;          // By lag from 0, then column modulo the width.
  cv::Mat ring_;                     // CV_8UC3, the same as colours; columns modulo the width, the base at the bottom.
  std::int64_t newest_column_ = -1;  // Columns count from time 0.
  bool any_ = false;
};

}  // namespace choreo::similarity
