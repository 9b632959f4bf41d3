// SPDX-License-Identifier: Apache-2.0
// The one drawing of a Z/Z* plot: where everything goes on the page, and the strokes. Private to Plot.
#pragma once

#include <string>
#include <vector>

#include "outputs/plot.hpp"
#include "outputs/plot_canvas.hpp"
#include "outputs/plot_ticks.hpp"

namespace choreo::outputs {

inline constexpr int kLeastWidthPx = 320;
inline constexpr int kMostWidthPx = 8000;

/// The columns of a page, in pixels; known before anything is measured, so that a raster can be made for it.
struct FigureGrid {
  double em = 0.0;  ///< Height of the type; everything else is a multiple of it.
  int left = 0;     ///< Where the raster begins.
  int raster = 0;   ///< How wide it is; even.
};
[[nodiscard]] FigureGrid figure_grid(int width_px);

/// Holds references to what a Plot holds, for the time of one drawing.
class Figure {
 public:
  Figure(const similarity::PlotRaster& raster, std::size_t frames, const std::vector<Thumbnail>& thumbnails,
         const PlotOptions& options, ValueRange range);

  [[nodiscard]] int width() const { return options_.width_px; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] cv::Rect raster_box() const;

  void draw(Canvas& canvas) const;

 private:
  struct Inks {
    Rgb page, text, quiet, hair, gap;
  };
  struct PlacedThumbnail {
    const Thumbnail* what;
    double x;  ///< Of its time on the axis.
    Box box;
  };
  /// A label on the time axis under the raster, which a leader must not cross.
  struct Obstacle {
    double left, right, top, bottom;
  };

  [[nodiscard]] bool triangle() const { return options_.form == PlotForm::kTriangle; }
  [[nodiscard]] double time_to_x(double seconds) const;
  [[nodiscard]] std::vector<Point> corners() const;
  [[nodiscard]] double key_width() const;
  [[nodiscard]] TimeTicks choose_ticks(double begin_s, double end_s, double pixels, bool across) const;
  void set_header();
  void place_thumbnails();
  void draw_header(Canvas& canvas) const;
  void draw_outline(Canvas& canvas) const;
  void draw_raster(Canvas& canvas) const;
  void draw_axes(Canvas& canvas) const;
  void draw_time_axis(Canvas& canvas, std::vector<Obstacle>& obstacles) const;
  void draw_side_axis(Canvas& canvas) const;
  void draw_thumbnails(Canvas& canvas, const std::vector<Obstacle>& obstacles) const;
  void draw_key(Canvas& canvas) const;
  void draw_square_key(Canvas& canvas, double right, double top) const;
  void draw_grey_key(Canvas& canvas, double right, double top) const;
  void line(Canvas& canvas, Point from, Point to, double width, Rgb color) const;

  const similarity::PlotRaster& raster_;
  const PlotOptions& options_;
  ValueRange range_;
  Inks inks_;
  TextMeter meter_;
  double em_;
  double thin_;  ///< The two widths of lines, whole pixels.
  double hair_;
  bool gaps_;
  std::string title_, facts_, subtitle_;
  std::vector<PlacedThumbnail> placed_;
  double key_top_ = 0.0;
  double data_x_ = 0.0, data_y_ = 0.0, data_width_ = 0.0, data_height_ = 0.0;
  int height_ = 0;
};

}  // namespace choreo::outputs
