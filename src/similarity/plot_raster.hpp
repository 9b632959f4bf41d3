// SPDX-License-Identifier: Apache-2.0
// Z and Z* reduced to the pixels of a picture: true time on both axes, means over areas, gaps kept apart from zero.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/matrix_view.hpp"

namespace choreo::similarity {

/// How a plot lays out a pair of times (a, b).
enum class PlotForm {
  kSquare,    ///< a to the right, b downwards; the identity axis is the diagonal from the top left.
  kTriangle,  ///< (a + b)/2 to the right, the lag |b - a| upwards; the identity axis is the base.
};

/// Which similarity a plot shows.
enum class PlotChannels {
  kBoth,   ///< Z red, Z* green and blue.
  kZ,      ///< Z alone, grey.
  kZstar,  ///< Z* alone, grey.
};

/// The similarities that are drawn as black (lo) and as full brightness (hi).
struct ValueRange {
  double lo = 0.0;
  double hi = 1.0;
};

/// Z and Z* by pixel, row-major, row 0 at the top, in [0, 1]. NaN: no body in any frame of the pixel, or, in a
/// triangle, a pixel outside it. `z` or `zstar` is empty where that similarity was not given.
struct PlotRaster {
  PlotForm form = PlotForm::kSquare;
  std::size_t width = 0;   ///< Pixels; covers [begin_s, end_s).
  std::size_t height = 0;  ///< Pixels; the width (square) or half of it (triangle: lags 0 to end_s - begin_s).
  double begin_s = 0.0;
  double end_s = 0.0;
  std::vector<float> z;
  std::vector<float> zstar;

  /// Whether a pixel belongs to the form at all; a pixel cut by a side of the triangle does.
  [[nodiscard]] bool inside(std::size_t row, std::size_t col) const;
};

/// The edges of the intervals in which frames are seen: frame i from edge i to edge i + 1, the last for as long as its
/// predecessor, a single one for 1/25 s.
/// @param times_s  N >= 1 seconds, finite, strictly increasing, any spacing.
/// @return         N + 1 seconds. Error (usage) where the times are not as said.
[[nodiscard]] std::vector<double> frame_edges(std::span<const double> times_s);

/// Reduces Z and Z*, row by row, while they are made or read, to a raster.
///
/// A pixel is the mean of the similarity, as a function of two continuous times that is constant over each pair of
/// frames, over the pixel's area; NaN are left out. In the triangle a pixel is a square on its tip in the matrix: it is
/// averaged there, from cells of half its diagonal, so nothing is drawn twice and no picture is rotated. Only pairs
/// with b <= a are looked at, so the raster of the square is symmetric to the last bit.
/// @cost  O(N^2) in all, each value read once; memory for the raster and one row.
class RasterReducer {
 public:
  /// @param times_s   as frame_edges; copied.
  /// @param width_px  > 0, even for a triangle.
  RasterReducer(PlotForm form, std::span<const double> times_s, std::size_t width_px);

  /// Takes row i; rows come in order, 0 to N - 1.
  /// @param z_row, zstar_row  at least the i + 1 values against frames 0 to i, in [0, 1] or NaN; either may be empty,
  ///                          then in every row.
  void add_row(std::size_t i, std::span<const float> z_row, std::span<const float> zstar_row);

  /// The raster of the rows so far (the others count as gaps); the reducer is spent.
  [[nodiscard]] PlotRaster finish();

 private:
  /// One similarity on its way: the pixel row that still collects, and what has been collected.
  struct Channel {
    bool used = false;
    std::vector<double> row_sum, row_weight;    // The open row of the cell grid.
    std::vector<double> band_sum, band_weight;  // One frame's row, averaged along its columns.
    std::vector<float> sum, weight;             // By pixel; a square keeps only means, in `sum`.
  };

  [[nodiscard]] double overlap(std::size_t frame, std::size_t cell) const;
  void reduce_columns(std::size_t i, std::span<const float> row, Channel& channel) const;
  void add_to_open_row(std::size_t i, std::size_t cell_row, float own, Channel& channel) const;
  void close_row(std::size_t cell_row, Channel& channel) const;
  void fold_into_triangle(std::size_t cell_row, Channel& channel) const;
  [[nodiscard]] std::vector<float> means(Channel& channel) const;

  PlotRaster raster_;
  std::size_t cells_ = 0;                 // Cells along one axis of the matrix: pixels, in a triangle two a pixel.
  std::vector<double> edges_;             // Frame edges in cells, N + 1, from 0 to cells_.
  std::vector<double> lengths_;           // Frame lengths in cells, N.
  std::vector<std::size_t> first_frame_;  // By cell: the first and the last frame that overlap it.
  std::vector<std::size_t> last_frame_;
  std::size_t next_row_ = 0;
  Channel z_, zstar_;
};

/// The raster of whole matrices: RasterReducer over all their rows.
/// @param z, zstar  N x N, symmetric, values in [0, 1] or NaN; either may be empty (0 x 0).
/// @param times_s   N seconds, as frame_edges. Error (usage) where the sizes differ.
[[nodiscard]] PlotRaster reduce(PlotForm form, MatrixView<const float> z, MatrixView<const float> zstar,
                                std::span<const double> times_s, std::size_t width_px);

/// The range that shows most: from the 1st percentile of the pixels that are drawn, rounded down to hundredths, to 1.
/// At least 0.05 wide, so that noise is never stretched to a picture. No value at all: 0 to 1.
[[nodiscard]] ValueRange auto_range(const PlotRaster& raster, PlotChannels channels);

/// 0 to 255 for a similarity: linear in the range, clamped, rounded to nearest.
[[nodiscard]] std::uint8_t brightness(float similarity, ValueRange range);

/// The picture of a raster: 8-bit BGR, height x width. Z is red, Z* green and blue, or one of them grey; pixels without
/// a body and outside the triangle have the colour `gap`.
/// @param channels  those that the raster has; otherwise all is gap.
[[nodiscard]] cv::Mat paint(const PlotRaster& raster, PlotChannels channels, ValueRange range, cv::Vec3b gap);

/// Every colour that a plot of both has: Z to the right, Z* upwards, each from 0 to 1. 8-bit BGR, 256 x 256.
[[nodiscard]] cv::Mat colour_key();

/// Whether any pixel inside the form has no value in one of the channels.
[[nodiscard]] bool has_gaps(const PlotRaster& raster, PlotChannels channels);

}  // namespace choreo::similarity
