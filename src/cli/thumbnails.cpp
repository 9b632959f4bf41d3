// SPDX-License-Identifier: Apache-2.0
#include "cli/thumbnails.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <opencv2/core.hpp>

namespace choreo::cli {

ThumbnailKeeper::ThumbnailKeeper(int count, std::vector<double> times_s)
    : count_(static_cast<std::size_t>(count)),
      times_s_(std::move(times_s)),
      // Sixteen to choose from for each one wanted: the nearest is then never far from its even place.
      evenly_(std::max<std::size_t>(1, 16 * count_)) {
  std::sort(times_s_.begin(), times_s_.end());
}

void ThumbnailKeeper::add(const cv::Mat& picture, const cv::Mat& mask, const body::MaskState& state, double time_s) {
  if (!times_s_.empty()) {
    bool wanted = false;
    for (; next_time_ < times_s_.size() && times_s_[next_time_] <= time_s; ++next_time_) wanted = true;
    if (wanted) at_times_.push_back(cut_out(picture, mask, state, time_s));
    return;
  }
  if (count_ > 0) evenly_.offer([&] { return cut_out(picture, mask, state, time_s); });
}

ThumbnailKeeper::Kept ThumbnailKeeper::cut_out(const cv::Mat& picture, const cv::Mat& mask,
                                               const body::MaskState& state, double time_s) {
  const auto box = state.box() + state.center();
  cv::Mat cut(box.size(), CV_8UC4);
  const cv::Mat colour = picture(box);
  const cv::Mat alpha = mask(box);
  const int channels[] = {0, 0, 1, 1, 2, 2, 3, 3};
  const cv::Mat parts[] = {colour, alpha};
  cv::mixChannels(parts, 2, &cut, 1, channels, 4);
  return {time_s, state.box(), cut};
}

std::vector<outputs::Thumbnail> ThumbnailKeeper::chosen(double from_s) const {
  std::vector<const Kept*> there;
  for (const auto* all : {&at_times_, &evenly_.kept()}) {
    for (const auto& kept : *all) {
      if (kept.time_s >= from_s) there.push_back(&kept);
    }
  }
  std::vector<const Kept*> picks;
  if (!times_s_.empty()) {
    picks = there;
  } else if (!there.empty()) {
    const double first = there.front()->time_s;
    const double length = there.back()->time_s - first;
    for (std::size_t i = 0; i < count_; ++i) {
      // In the middle of its share of the time axis.
      const double place = first + length * (double(i) + 0.5) / double(count_);
      const auto* nearest = *std::min_element(there.begin(), there.end(), [&](const Kept* a, const Kept* b) {
        return std::abs(a->time_s - place) < std::abs(b->time_s - place);
      });
      if (picks.empty() || picks.back() != nearest) picks.push_back(nearest);
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
