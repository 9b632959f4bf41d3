// SPDX-License-Identifier: Apache-2.0
#include "similarity/plot_raster.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <fmt/format.h>

#include "core/error.hpp"

namespace choreo::similarity {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr double kSingleFrameSeconds = 1.0 / 25.0;
/// Edges this near to a cell's edge (in cells) are on it: rounding must not leave a sliver of a frame in a gap.
constexpr double kSnap = 1e-9;
constexpr double kNarrowestAutoRange = 0.05;

/// Sum of w z and of w over the values that are numbers. Four lanes in a fixed order: fast, and the same everywhere.
void accumulate(const float* values, const double* weights, std::size_t n, double& sum, double& weight) {
  double s[4] = {}, w[4] = {};
  std::size_t k = 0;
  for (; k + 4 <= n; k += 4) {
    for (std::size_t lane = 0; lane < 4; ++lane) {
      const double v = values[k + lane];
      const bool number = v == v;
      s[lane] += (number ? v : 0.0) * weights[k + lane];
      w[lane] += number ? weights[k + lane] : 0.0;
    }
  }
  for (; k < n; ++k) {
    if (std::isnan(values[k])) continue;
    s[0] += static_cast<double>(values[k]) * weights[k];
    w[0] += weights[k];
  }
  sum += (s[0] + s[1]) + (s[2] + s[3]);
  weight += (w[0] + w[1]) + (w[2] + w[3]);
}

float mean(double sum, double weight) { return weight > 0.0 ? static_cast<float>(sum / weight) : kNaN; }

}  // namespace

bool PlotRaster::inside(std::size_t row, std::size_t col) const {
  if (form == PlotForm::kSquare) return row < height && col < width;
  const std::size_t lag = height - 1 - row;
  return row < height && col >= lag && col + lag < width;
}

std::vector<double> frame_edges(std::span<const double> times_s) {
  if (times_s.empty()) throw usage_error("there is no frame to plot");
  std::vector<double> edges(times_s.begin(), times_s.end());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (!std::isfinite(edges[i])) throw usage_error(fmt::format("the time of frame {} is not a number", i));
    if (i > 0 && edges[i] <= edges[i - 1]) {
      throw usage_error(fmt::format("the time \"{}\" of frame {} is not after that of the frame before, \"{}\"",
                                    edges[i], i, edges[i - 1]));
    }
  }
  const std::size_t n = edges.size();
  edges.push_back(edges[n - 1] + (n > 1 ? edges[n - 1] - edges[n - 2] : kSingleFrameSeconds));
  return edges;
}

RasterReducer::RasterReducer(PlotForm form, std::span<const double> times_s, std::size_t width_px) {
  assert(width_px > 0 && (form == PlotForm::kSquare || width_px % 2 == 0));
  edges_ = frame_edges(times_s);
  const bool triangle = form == PlotForm::kTriangle;
  raster_.form = form;
  raster_.width = width_px;
  raster_.height = triangle ? width_px / 2 : width_px;
  raster_.begin_s = edges_.front();
  raster_.end_s = edges_.back();
  cells_ = triangle ? 2 * width_px : width_px;

  const double scale = static_cast<double>(cells_) / (raster_.end_s - raster_.begin_s);
  for (double& edge : edges_) {
    edge = (edge - raster_.begin_s) * scale;
    if (std::abs(edge - std::round(edge)) < kSnap) edge = std::round(edge);
  }
  edges_.back() = static_cast<double>(cells_);

  const std::size_t frames = times_s.size();
  lengths_.resize(frames);
  for (std::size_t i = 0; i < frames; ++i) lengths_[i] = edges_[i + 1] - edges_[i];
  first_frame_.resize(cells_);
  last_frame_.resize(cells_);
  for (std::size_t cell = 0, frame = 0; cell < cells_; ++cell) {
    while (frame + 1 < frames && edges_[frame + 1] <= static_cast<double>(cell)) ++frame;
    first_frame_[cell] = frame;
    std::size_t last = frame;
    while (last + 1 < frames && edges_[last + 1] < static_cast<double>(cell + 1)) ++last;
    last_frame_[cell] = last;
  }
}

double RasterReducer::overlap(std::size_t frame, std::size_t cell) const {
  const double begin = std::max(edges_[frame], static_cast<double>(cell));
  const double end = std::min(edges_[frame + 1], static_cast<double>(cell + 1));
  return std::max(0.0, end - begin);
}

void RasterReducer::add_row(std::size_t i, std::span<const float> z_row, std::span<const float> zstar_row) {
  assert(i == next_row_ && i < lengths_.size());
  ++next_row_;
  // The cells of the frame: it may be narrower than one or span many.
  const auto first_cell = static_cast<std::size_t>(edges_[i]);
  const auto last_cell = std::min(cells_, static_cast<std::size_t>(std::ceil(edges_[i + 1]))) - 1;
  for (auto [channel, row] : {std::pair{&z_, z_row}, std::pair{&zstar_, zstar_row}}) {
    if (row.empty()) continue;
    assert(row.size() > i);
    if (!channel->used) {
      channel->used = true;
      for (auto* v : {&channel->row_sum, &channel->row_weight, &channel->band_sum, &channel->band_weight}) {
        v->assign(cells_, 0.0);
      }
      const bool square = raster_.form == PlotForm::kSquare;
      channel->sum.assign(raster_.width * raster_.height, square ? kNaN : 0.0F);
      if (!square) channel->weight.assign(raster_.width * raster_.height, 0.0F);
    }
    reduce_columns(i, row, *channel);
    for (std::size_t cell = first_cell; cell <= last_cell; ++cell) {
      add_to_open_row(i, cell, row[i], *channel);
      if (edges_[i + 1] >= static_cast<double>(cell + 1)) close_row(cell, *channel);
    }
  }
}

/// One frame against all before it: sums over each cell's frames j < i, weighted by overlap.
void RasterReducer::reduce_columns(std::size_t i, std::span<const float> row, Channel& channel) const {
  const auto last_cell = std::min(cells_, static_cast<std::size_t>(std::ceil(edges_[i + 1]))) - 1;
  for (std::size_t cell = 0; cell <= last_cell; ++cell) {
    double sum = 0.0, weight = 0.0;
    const std::size_t first = first_frame_[cell];
    const std::size_t end = std::min(last_frame_[cell] + 1, i);  // One past the last.
    if (first < end) {
      const double first_share = overlap(first, cell);
      accumulate(&row[first], &first_share, 1, sum, weight);
      if (end - first > 1) {
        accumulate(&row[first + 1], &lengths_[first + 1], end - first - 2, sum, weight);
        const double last_share = overlap(end - 1, cell);
        accumulate(&row[end - 1], &last_share, 1, sum, weight);
      }
    }
    channel.band_sum[cell] = sum;
    channel.band_weight[cell] = weight;
  }
}

/// On a cell of the diagonal every pair j < i stands for (j, i) too; left of it no frame after i can reach.
void RasterReducer::add_to_open_row(std::size_t i, std::size_t cell_row, float own, Channel& channel) const {
  const double share = overlap(i, cell_row);
  for (std::size_t cell = 0; cell <= cell_row; ++cell) {
    const double times = cell == cell_row ? 2.0 * share : share;
    channel.row_sum[cell] += times * channel.band_sum[cell];
    channel.row_weight[cell] += times * channel.band_weight[cell];
  }
  if (std::isnan(own)) return;
  for (auto cell = static_cast<std::size_t>(edges_[i]); cell <= cell_row; ++cell) {
    const double area = share * overlap(i, cell);
    channel.row_sum[cell] += area * static_cast<double>(own);
    channel.row_weight[cell] += area;
  }
}

void RasterReducer::close_row(std::size_t cell_row, Channel& channel) const {
  if (raster_.form == PlotForm::kSquare) {
    for (std::size_t cell = 0; cell <= cell_row; ++cell) {
      const float value = mean(channel.row_sum[cell], channel.row_weight[cell]);
      channel.sum[cell_row * raster_.width + cell] = value;
      channel.sum[cell * raster_.width + cell_row] = value;
    }
  } else {
    fold_into_triangle(cell_row, channel);
  }
  std::fill(channel.row_sum.begin(), channel.row_sum.end(), 0.0);
  std::fill(channel.row_weight.begin(), channel.row_weight.end(), 0.0);
}

/// A cell (p, q), q <= p, is in the triangle a square on its tip, a quarter of a pixel in each direction around
/// ((p + q + 1)/4, (p - q)/4): it lies in one pixel, or is cut in halves by the edge between two.
void RasterReducer::fold_into_triangle(std::size_t p, Channel& channel) const {
  const auto add = [&](std::size_t lag, std::size_t col, double share, std::size_t q) {
    const std::size_t at = (raster_.height - 1 - lag) * raster_.width + col;
    channel.sum[at] += static_cast<float>(share * channel.row_sum[q]);
    channel.weight[at] += static_cast<float>(share * channel.row_weight[q]);
  };
  for (std::size_t q = 0; q <= p; ++q) {
    const std::size_t s = p + q + 1, d = p - q;
    if (s % 4 == 0) {
      add(d / 4, s / 4 - 1, 0.5, q);
      add(d / 4, s / 4, 0.5, q);
    } else if (d % 4 == 0) {
      add(d / 4, s / 4, 0.5, q);
      if (d > 0) add(d / 4 - 1, s / 4, 0.5, q);
    } else {
      add(d / 4, s / 4, 1.0, q);
    }
  }
}

std::vector<float> RasterReducer::means(Channel& channel) const {
  if (!channel.used) return {};
  if (raster_.form == PlotForm::kTriangle) {
    for (std::size_t k = 0; k < channel.sum.size(); ++k) channel.sum[k] = mean(channel.sum[k], channel.weight[k]);
  }
  return std::move(channel.sum);
}

PlotRaster RasterReducer::finish() {
  // Interrupted within a row of cells: what it has so far counts.
  if (next_row_ > 0 && next_row_ < lengths_.size() && edges_[next_row_] != std::floor(edges_[next_row_])) {
    for (auto* channel : {&z_, &zstar_}) {
      if (channel->used) close_row(static_cast<std::size_t>(edges_[next_row_]), *channel);
    }
  }
  raster_.z = means(z_);
  raster_.zstar = means(zstar_);
  return std::move(raster_);
}

PlotRaster reduce(PlotForm form, MatrixView<const float> z, MatrixView<const float> zstar,
                  std::span<const double> times_s, std::size_t width_px) {
  for (const auto& m : {z, zstar}) {
    if (m.rows() != 0 && (m.rows() != times_s.size() || m.cols() != times_s.size())) {
      throw usage_error(
          fmt::format("a matrix of {} x {} does not fit the {} frames", m.rows(), m.cols(), times_s.size()));
    }
  }
  RasterReducer reducer(form, times_s, width_px);
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    reducer.add_row(i, z.rows() ? z.row(i) : std::span<const float>{},
                    zstar.rows() ? zstar.row(i) : std::span<const float>{});
  }
  return reducer.finish();
}

ValueRange auto_range(const PlotRaster& raster, PlotChannels channels) {
  std::vector<float> values;
  for (const auto* channel : {&raster.z, &raster.zstar}) {
    if (channels == (channel == &raster.z ? PlotChannels::kZstar : PlotChannels::kZ)) continue;
    std::copy_if(channel->begin(), channel->end(), std::back_inserter(values), [](float v) { return !std::isnan(v); });
  }
  if (values.empty()) return {};
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 100);
  std::nth_element(values.begin(), at, values.end());
  const double lo = std::floor(static_cast<double>(*at) * 100.0) / 100.0;
  return {std::clamp(lo, 0.0, 1.0 - kNarrowestAutoRange), 1.0};
}

std::uint8_t brightness(float similarity, ValueRange range) {
  const double share = (static_cast<double>(similarity) - range.lo) / (range.hi - range.lo);
  return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(share, 0.0, 1.0)));
}

cv::Mat paint(const PlotRaster& raster, PlotChannels channels, ValueRange range, cv::Vec3b gap) {
  cv::Mat picture(static_cast<int>(raster.height), static_cast<int>(raster.width), CV_8UC3, cv::Scalar(gap));
  const auto& red = channels == PlotChannels::kZstar ? raster.zstar : raster.z;
  const auto& cyan = channels == PlotChannels::kZ ? raster.z : raster.zstar;
  if (red.empty() || cyan.empty()) return picture;
  std::size_t k = 0;
  for (int y = 0; y < picture.rows; ++y) {
    auto* out = picture.ptr<cv::Vec3b>(y);
    for (int x = 0; x < picture.cols; ++x, ++k) {
      if (std::isnan(red[k]) || std::isnan(cyan[k])) continue;
      const auto c = brightness(cyan[k], range);
      out[x] = {c, c, brightness(red[k], range)};
    }
  }
  return picture;
}

cv::Mat colour_key() {
  constexpr int kShades = 256;
  cv::Mat plate(kShades, kShades, CV_8UC3);
  for (int row = 0; row < kShades; ++row) {
    for (int col = 0; col < kShades; ++col) {
      const auto cyan = static_cast<std::uint8_t>(kShades - 1 - row);
      plate.at<cv::Vec3b>(row, col) = {cyan, cyan, static_cast<std::uint8_t>(col)};
    }
  }
  return plate;
}

bool has_gaps(const PlotRaster& raster, PlotChannels channels) {
  const auto& red = channels == PlotChannels::kZstar ? raster.zstar : raster.z;
  const auto& cyan = channels == PlotChannels::kZ ? raster.z : raster.zstar;
  if (red.empty() || cyan.empty()) return true;
  for (std::size_t row = 0, k = 0; row < raster.height; ++row) {
    for (std::size_t col = 0; col < raster.width; ++col, ++k) {
      if (raster.inside(row, col) && (std::isnan(red[k]) || std::isnan(cyan[k]))) return true;
    }
  }
  return false;
}

}  // namespace choreo::similarity
