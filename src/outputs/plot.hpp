// SPDX-License-Identifier: Apache-2.0
// A Z/Z* plot as a figure for a paper: the raster with its axes in true time, a key, a title, pictures along the axis.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/matrix_view.hpp"
#include "similarity/plot_raster.hpp"

namespace choreo::outputs {

using similarity::PlotChannels;
using similarity::PlotForm;
using similarity::ValueRange;

struct PlotOptions {
  PlotForm form = PlotForm::kSquare;
  PlotChannels channels = PlotChannels::kBoth;
  int width_px = 1600;                             ///< Of the page, 320 to 8000; type and lines grow with it.
  std::optional<ValueRange> range = ValueRange{};  ///< Black and full brightness; none: similarity::auto_range.
  bool dark = false;                               ///< A dark page for a projector, else a white one for print.
  std::string title;                               ///< Such as the name of the source; may be empty.
  std::string subtitle;                            ///< Such as the settings; may be empty.
  std::string gap = "no body";                     ///< What the key calls times without a state.

  /// Error (usage) where a value is out of its range.
  void validate() const;
};

/// A small picture that belongs to a time.
struct Thumbnail {
  double time_s = 0.0;
  cv::Mat picture;  ///< 8-bit BGR, or BGRA with straight alpha: outside of the body transparent.
};

/// What a plot shows.
struct PlotData {
  MatrixView<const float> z;        ///< N x N, symmetric, in [0, 1], NaN without a body; may be empty if not drawn.
  MatrixView<const float> zstar;    ///< Likewise.
  std::span<const double> times_s;  ///< N seconds, strictly increasing, of any spacing.
  std::vector<Thumbnail> thumbnails = {};  ///< Those outside of the time axis, or in another's place, are left out.
};

/// How wide the raster in a page of these options is, for a RasterReducer of one's own; even.
[[nodiscard]] std::size_t raster_width_px(const PlotOptions& options);

/// A finished figure; drawn alike as PNG and as SVG, and the same bytes on every run.
class Plot {
 public:
  /// Reduces the matrices; they need not live any longer. O(N^2), then everything depends on the page only.
  /// Error (usage) where options or data are not as said.
  Plot(const PlotData& data, PlotOptions options);

  /// Of a raster made by a RasterReducer of width raster_width_px(options) and the same form.
  /// @param frames  how many frames it was made of, for the title.
  Plot(similarity::PlotRaster raster, std::size_t frames, std::vector<Thumbnail> thumbnails, PlotOptions options);

  /// Error (failure) where the file cannot be written whole; then nothing is left under its name.
  void write_png(const std::filesystem::path& path) const;
  void write_svg(const std::filesystem::path& path) const;

  /// The page, 8-bit BGR.
  [[nodiscard]] cv::Mat render() const;

  /// Where on the page the raster is, in whole pixels.
  [[nodiscard]] cv::Rect raster_box() const;
  /// The range that is drawn.
  [[nodiscard]] ValueRange range() const { return range_; }

 private:
  similarity::PlotRaster raster_;
  std::size_t frames_ = 0;
  std::vector<Thumbnail> thumbnails_;
  PlotOptions options_;
  ValueRange range_;
};

}  // namespace choreo::outputs
