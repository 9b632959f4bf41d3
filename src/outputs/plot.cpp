// SPDX-License-Identifier: Apache-2.0
#include "outputs/plot.hpp"

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "core/error.hpp"
#include "outputs/plot_canvas.hpp"
#include "outputs/plot_figure.hpp"

namespace choreo::outputs {
namespace {

namespace fs = std::filesystem;

/// Writes all of a file or nothing: under a temporary name, then renamed; devices and pipes directly.
void write_file(const fs::path& path, const std::string& bytes) {
  std::error_code ignored;
  const auto status = fs::status(path, ignored);
  const bool plain = !fs::exists(status) || fs::is_regular_file(status);
  const fs::path target = plain ? fs::path(path.string() + ".partial") : path;
  const auto fail = [&](int reason) {
    if (plain) fs::remove(target, ignored);
    throw failure(fmt::format("cannot write the plot: {}", std::strerror(reason)), path.string());
  };
  std::FILE* file = std::fopen(target.c_str(), "wb");
  if (file == nullptr) fail(errno);
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size() && std::fflush(file) == 0;
  const int reason = errno;
  // A full disk may show only here.
  if (std::fclose(file) != 0 || !written) fail(written ? errno : reason);
  if (plain && std::rename(target.c_str(), path.c_str()) != 0) fail(errno);
}

}  // namespace

void PlotOptions::validate() const {
  if (width_px < kLeastWidthPx || width_px > kMostWidthPx) {
    throw usage_error(fmt::format("a plot cannot be \"{}\" pixels wide", width_px), {},
                      fmt::format("{} to {}", kLeastWidthPx, kMostWidthPx));
  }
  if (range && !(range->lo >= 0.0 && range->lo < range->hi && range->hi <= 1.0)) {
    throw usage_error(fmt::format("\"{} to {}\" is not a range of similarities", range->lo, range->hi), {},
                      "two numbers from 0 to 1, the smaller first");
  }
}

std::size_t raster_width_px(const PlotOptions& options) {
  options.validate();
  return static_cast<std::size_t>(figure_grid(options.width_px).raster);
}

Plot::Plot(const PlotData& data, PlotOptions options)
    : Plot(similarity::reduce(options.form,
                              options.channels == PlotChannels::kZstar ? MatrixView<const float>{} : data.z,
                              options.channels == PlotChannels::kZ ? MatrixView<const float>{} : data.zstar,
                              data.times_s, raster_width_px(options)),
           data.times_s.size(), data.thumbnails, options) {}

Plot::Plot(similarity::PlotRaster raster, std::size_t frames, std::vector<Thumbnail> thumbnails, PlotOptions options)
    : raster_(std::move(raster)), frames_(frames), thumbnails_(std::move(thumbnails)), options_(std::move(options)) {
  if (raster_.width != raster_width_px(options_) || raster_.form != options_.form) {
    throw usage_error(fmt::format("a raster \"{}\" pixels wide does not fit the plot", raster_.width), {},
                      fmt::format("{}, and of the same form", raster_width_px(options_)));
  }
  for (const auto& t : thumbnails_) {
    if (t.picture.empty() || (t.picture.type() != CV_8UC3 && t.picture.type() != CV_8UC4)) {
      throw usage_error(fmt::format("the picture for {} s is neither 8-bit BGR nor BGRA", t.time_s));
    }
  }
  range_ = options_.range ? *options_.range : similarity::auto_range(raster_, options_.channels);
}

void Plot::write_png(const fs::path& path) const {
  const Figure figure(raster_, frames_, thumbnails_, options_, range_);
  PixelCanvas canvas(figure.width(), figure.height());
  figure.draw(canvas);
  write_file(path, canvas.png());
}

void Plot::write_svg(const fs::path& path) const {
  const Figure figure(raster_, frames_, thumbnails_, options_, range_);
  SvgCanvas canvas(figure.width(), figure.height());
  figure.draw(canvas);
  write_file(path, canvas.svg());
}

cv::Mat Plot::render() const {
  const Figure figure(raster_, frames_, thumbnails_, options_, range_);
  PixelCanvas canvas(figure.width(), figure.height());
  figure.draw(canvas);
  return canvas.bgr();
}

cv::Rect Plot::raster_box() const { return Figure(raster_, frames_, thumbnails_, options_, range_).raster_box(); }

}  // namespace choreo::outputs
