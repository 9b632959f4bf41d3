// SPDX-License-Identifier: Apache-2.0
#include "body/silhouette_features.hpp"

#include <opencv2/core.hpp>

namespace choreo::body {

double contraction(int area_px, cv::Size box) { return double(area_px) / double(box.area()); }

double MotionMeter::add(const cv::Mat& mask, int area_px, double time_s) {
  // Half a nanosecond of slack: the difference of two times read as doubles must not decide.
  while (!past_.empty() && past_.front().time_s < time_s - window_s_ - 5e-10) past_.pop_front();
  double motion = 0;
  if (!past_.empty()) {
    cv::Mat covered = past_.front().mask.clone();
    for (std::size_t i = 1; i < past_.size(); ++i) covered |= past_[i].mask;
    covered &= ~mask;
    motion = double(cv::countNonZero(covered)) / double(area_px);
  }
  past_.push_back({mask, time_s});
  return motion;
}

}  // namespace choreo::body
