// SPDX-License-Identifier: Apache-2.0
#include "cli/thumbnails.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <opencv2/core.hpp>

namespace choreo::cli {

ThumbnailKeeper::ThumbnailKeeper(int count, std::vector<double> times_s)
    : count_(static_cast<std::size_t>(count)), times_s_(std::move(times_s)) {
  std::sort(times_s_.begin(), times_s_.end());
}

void ThumbnailKeeper::add(const cv::Mat& picture, const cv::Mat& mask, const body::MaskState& state, double time_s) {
  if (!times_s_.empty()) {
    bool wanted = false;
    for (; next_time_ < times_s_.size() && times_s_[next_time_] <= time_s; ++next_time_) wanted = true;
    if (wanted) keep(picture, mask, state, time_s);
    return;
  }
  if (count_ == 0) return;
  // Sixteen to choose from for each one wanted: the nearest is then never far from its even place.
  const std::size_t most = 16 * count_;
  const auto number = seen_++;
  if (number % step_ != 0) return;
  if (kept_.size() == most) {
    std::size_t k = 0;
    for (std::size_t i = 0; i < kept_.size(); i += 2) kept_[k++] = std::move(kept_[i]);
    kept_.resize(k);
    step_ *= 2;
    if (number % step_ != 0) return;
  }
  keep(picture, mask, state, time_s);
}

void ThumbnailKeeper::keep(const cv::Mat& picture, const cv::Mat& mask, const body::MaskState& state, double time_s) {
  const auto box = state.box() + state.center();
  cv::Mat cut(box.size(), CV_8UC4);
  const cv::Mat colour = picture(box);
  const cv::Mat alpha = mask(box);
  const int channels[] = {0, 0, 1, 1, 2, 2, 3, 3};
  const cv::Mat parts[] = {colour, alpha};
  cv::mixChannels(parts, 2, &cut, 1, channels, 4);
  kept_.push_back({time_s, state.box(), cut});
}

std::vector<outputs::Thumbnail> ThumbnailKeeper::chosen() const {
  std::vector<const Kept*> picks;
  if (!times_s_.empty()) {
    for (const auto& kept : kept_) picks.push_back(&kept);
  } else if (!kept_.empty()) {
    const double first = kept_.front().time_s;
    const double length = kept_.back().time_s - first;
    for (std::size_t i = 0; i < count_; ++i) {
      // In the middle of its share of the time axis.
      const double place = first + length * (double(i) + 0.5) / double(count_);
      const auto nearest = std::min_element(kept_.begin(), kept_.end(), [&](const Kept& a, const Kept& b) {
        return std::abs(a.time_s - place) < std::abs(b.time_s - place);
      });
      if (picks.empty() || picks.back() != &*nearest) picks.push_back(&*nearest);
    }
  }
  cv::Rect canvas;
  for (const auto* pick : picks) canvas = canvas.empty() ? pick->box : (canvas | pick->box);
  std::vector<outputs::Thumbnail> thumbnails;
  for (const auto* pick : picks) {
    cv::Mat picture = cv::Mat::zeros(canvas.size(), CV_8UC4);
    pick->picture.copyTo(picture(pick->box - canvas.tl()));
    thumbnails.push_back({pick->time_s, picture});
  }
  return thumbnails;
}

}  // namespace choreo::cli
