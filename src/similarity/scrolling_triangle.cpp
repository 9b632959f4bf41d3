// SPDX-License-Identifier: Apache-2.0
#include "similarity/scrolling_triangle.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "similarity/plot_raster.hpp"

namespace choreo::similarity {
namespace {

constexpr double kPause = 0.5;  // Seconds; shorter ones are drawn over.

}  // namespace

ScrollingTriangle::ScrollingTriangle(double span_s, int width_px, cv::Vec3b gap, cv::Vec3b blank)
    : span_s_(span_s), width_(width_px), height_(width_px / 2), pitch_s_(span_s / width_px), gap_(gap), blank_(blank) {
  assert(span_s > 0 && width_px > 0 && width_px % 2 == 0);
  cells_.resize(std::size_t(width_) * std::size_t(height_));
  ring_ = cv::Mat(height_, width_, CV_8UC3, cv::Scalar(blank));
}

void ScrollingTriangle::add_row(double time_s, std::span<const float> z, std::span<const float> zstar) {
  assert(!z.empty() && z.size() == zstar.size());
  assert(times_s_.empty() || time_s > times_s_.back());
  // A frame was on since the one before it, unless nothing came for a while: a device that was gone shows nothing.
  const double step_s = times_s_.empty() ? pitch_s_ : time_s - times_s_.back();
  const double before_s =
      time_s - (times_s_.size() > 1 ? std::min(step_s, std::max(kPause, 4 * last_step_s_)) : step_s);
  last_step_s_ = step_s;
  times_s_.push_back(time_s);
  // One frame from before the span stays: pixels at its edge may lie between two frames.
  while (times_s_.size() > 2 && times_s_[1] < time_s - span_s_) times_s_.pop_front();
  scroll_to(time_s);
  // The newest ones; the history may be shorter than the picture, or longer.
  const auto count = std::min(z.size(), times_s_.size());
  while (times_s_.size() > count) times_s_.pop_front();
  z = z.last(count);
  zstar = zstar.last(count);
  // A bit wider still has its pair in nearly every pixel, and a rate that is just that of the pixels never changes
  // sides.
  constexpr double kNarrow = 1.25;
  if (time_s - before_s <= kNarrow * pitch_s_) {
    put_provisional(before_s, z, zstar);
    put_means(z, zstar);
  } else {
    put_samples(before_s, z, zstar);
  }
}

void ScrollingTriangle::scroll_to(double time_s) {
  const auto column = static_cast<std::int64_t>(std::floor(time_s / pitch_s_));
  auto from = any_ ? newest_column_ + 1 : column - width_ + 1;
  from = std::max(from, column - width_ + 1);
  for (auto c = from; c <= column; ++c) {
    const auto x = static_cast<int>(((c % width_) + width_) % width_);
    for (int lag = 0; lag < height_; ++lag) cells_[std::size_t(lag) * std::size_t(width_) + std::size_t(x)] = {};
    ring_.col(x).setTo(cv::Scalar(blank_));
  }
  newest_column_ = any_ ? std::max(newest_column_, column) : column;
  any_ = true;
}

void ScrollingTriangle::add(std::int64_t column, int lag, float z, float zstar, bool provisional) {
  if (lag < 0 || lag >= height_ || column > newest_column_ || column <= newest_column_ - width_) return;
  const auto x = static_cast<int>(((column % width_) + width_) % width_);
  auto& cell = cells_[std::size_t(lag) * std::size_t(width_) + std::size_t(x)];
  auto& pixel = ring_.at<cv::Vec3b>(height_ - 1 - lag, x);
  if (cell.pairs > 0 && provisional) return;
  if (std::isnan(z) || std::isnan(zstar)) {
    if (cell.pairs == 0) pixel = gap_;
    return;
  }
  auto mean = cell;
  ++mean.pairs;
  mean.z += (z - mean.z) / static_cast<float>(mean.pairs);
  mean.zstar += (zstar - mean.zstar) / static_cast<float>(mean.pairs);
  const auto cyan = brightness(mean.zstar, {});
  pixel = {cyan, cyan, brightness(mean.z, {})};
  if (!provisional) cell = mean;
}

// Frames closer than pixels: every pair into its pixel.
void ScrollingTriangle::put_means(std::span<const float> z, std::span<const float> zstar) {
  const double now = times_s_.back();
  for (std::size_t j = 0; j < z.size(); ++j) {
    const double then = times_s_[j];
    add(static_cast<std::int64_t>(std::floor((now + then) / 2 / pitch_s_)),
        static_cast<int>((now - then) / (2 * pitch_s_)), z[j], zstar[j], false);
  }
}

// Where times are uneven some pixels get no pair of their own; until they do, they show the one at their centre.
void ScrollingTriangle::put_provisional(double before_s, std::span<const float> z, std::span<const float> zstar) {
  for_each_point(1, before_s,
                 [&](std::int64_t column, int lag, std::size_t j) { add(column, lag, z[j], zstar[j], true); });
}

// Frames wider than pixels: four points a pixel, since one alone would pass over every second lag where a frame is
// about as wide as a pixel.
void ScrollingTriangle::put_samples(double before_s, std::span<const float> z, std::span<const float> zstar) {
  for_each_point(2, before_s,
                 [&](std::int64_t column, int lag, std::size_t j) { add(column, lag, z[j], zstar[j], false); });
}

// Visits the points, `fine` x `fine` evenly spread over each pixel, whose later time lies within the newest frame,
// which was on since `before_s`; `j` is the frame that was on at the earlier time.
template <typename Visit>
void ScrollingTriangle::for_each_point(int fine, double before_s, Visit visit) const {
  const double now = times_s_.back();
  const double pitch = pitch_s_ / fine;
  auto newest_j = static_cast<std::ptrdiff_t>(times_s_.size()) - 1;
  for (int row = 0; row < height_ * fine; ++row) {
    // Half the lag of the point; those of the lowest row reach down to the axis.
    const double half = row == 0 ? 0.0 : (row + 0.5) * pitch;
    const auto first = static_cast<std::int64_t>(std::floor((before_s - half) / pitch - 0.5)) + 1;
    const auto last = static_cast<std::int64_t>(std::floor((now - half) / pitch - 0.5));
    auto j = newest_j;
    for (auto point = last; point >= first; --point) {
      const double then = (static_cast<double>(point) + 0.5) * pitch - half;
      if (then < times_s_.front()) break;
      // The frame that was on at that time is the first at or after it.
      while (j > 0 && times_s_[std::size_t(j - 1)] >= then) --j;
      if (point == last) newest_j = j;
      visit(point >= 0 ? point / fine : (point - fine + 1) / fine, row / fine, static_cast<std::size_t>(j));
    }
  }
}

cv::Mat ScrollingTriangle::picture() const {
  cv::Mat out(height_, width_, CV_8UC3, cv::Scalar(blank_));
  if (!any_) return out;
  const auto split = static_cast<int>((((newest_column_ + 1) % width_) + width_) % width_);
  if (split < width_) ring_.colRange(split, width_).copyTo(out.colRange(0, width_ - split));
  if (split > 0) ring_.colRange(0, split).copyTo(out.colRange(width_ - split, width_));
  return out;
}

}  // namespace choreo::similarity
