// SPDX-License-Identifier: Apache-2.0
#include "vision/wall_learner.hpp"

#include <algorithm>
#include <utility>

#include "vision/tone_curve.hpp"

namespace choreo::vision {
namespace {

constexpr std::size_t kMostKept = 40;
constexpr double kLongestPeriod_s = 1.6;  // Then the last minute is looked at.
constexpr double kLongestWait_s = 20.0;

}  // namespace

void WallLearner::add(const cv::Mat& picture, double time_s, const cv::Mat& background, const cv::Mat& except) {
  if (!first_s_) first_s_ = time_s;
  // Half a millisecond of grace: time stamps are rounded.
  if (last_s_ && time_s - *last_s_ < period_s_ - 5e-4) return;
  last_s_ = time_s;
  if (kept_.size() == kMostKept) {
    if (period_s_ < kLongestPeriod_s) {
      for (std::size_t i = 2; i < kept_.size(); i += 2) std::swap(kept_[i / 2], kept_[i]);
      kept_.resize(kMostKept / 2);
      period_s_ *= 2;
    } else {
      kept_.erase(kept_.begin());
    }
  }
  kept_.push_back(ToneCurve(picture, background, except).apply(picture));
  if (time_s - *first_s_ >= next_ask_s_) {
    due_ = true;
    next_ask_s_ += std::min(kLongestWait_s, 0.6 * next_ask_s_);
  }
}

BackgroundEstimate WallLearner::ask(BackgroundEstimate so_far) {
  due_ = false;
  return with_inferred_wall(std::move(so_far), kept_);
}

}  // namespace choreo::vision
