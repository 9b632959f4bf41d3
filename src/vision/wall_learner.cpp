// SPDX-License-Identifier: Apache-2.0
#include "vision/wall_learner.hpp"

#include <algorithm>

#include "vision/lots.hpp"
#include "vision/tone_curve.hpp"

namespace choreo::vision {
namespace {

constexpr std::size_t kMostKept = 40;
constexpr double kPeriod_s = 0.1;
constexpr double kOldest_s = 60.0;
constexpr double kLongestWait_s = 20.0;

}  // namespace

// A sample of the last minute by lot: evenly spaced pictures of somebody who moves to a beat may all show one pose.
void WallLearner::keep(const cv::Mat& picture, double time_s) {
  std::erase_if(kept_, [&](const Kept& kept) { return kept.time_s < time_s - kOldest_s; });
  kept_.push_back({time_s, lot_of(offered_++), picture});
  if (kept_.size() <= kMostKept) return;
  kept_.erase(std::min_element(kept_.begin(), kept_.end(), [](const Kept& a, const Kept& b) { return a.lot < b.lot; }));
}

std::optional<InferredWall> WallLearner::add(const cv::Mat& picture, double time_s, const cv::Mat& background,
                                             const cv::Mat& except) {
  if (!first_s_) first_s_ = time_s;
  // Half a millisecond of grace: time stamps are rounded.
  if (!last_s_ || time_s - *last_s_ >= kPeriod_s - 5e-4) {
    last_s_ = time_s;
    keep(ToneCurve(picture, background, except).apply(picture), time_s);
  }
  if (inference_) {
    if (!inference_->advance()) return std::nullopt;
    auto wall = inference_->wall();
    inference_.reset();
    return wall;
  }
  if (time_s - *first_s_ >= next_ask_s_) {
    next_ask_s_ += std::min(kLongestWait_s, 0.6 * next_ask_s_);
    std::vector<cv::Mat> pictures;
    for (const auto& kept : kept_) pictures.push_back(kept.picture);
    inference_.emplace(std::move(pictures), noise_);
  }
  return std::nullopt;
}

}  // namespace choreo::vision
