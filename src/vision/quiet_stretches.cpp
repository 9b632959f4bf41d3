// SPDX-License-Identifier: Apache-2.0
#include "vision/quiet_stretches.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <opencv2/imgproc.hpp>

#include "vision/difference.hpp"
#include "vision/tone_curve.hpp"

namespace choreo::vision {
namespace {

constexpr int kSmallRows = 90;         // Enough to see a hand move, and noise is averaged away.
constexpr double kChange = 8.0;        // Grey levels at that size.
constexpr double kQuietShare = 0.002;  // Of the picture.
constexpr double kLeastStretch_s = 0.4;
constexpr int kMostSummed = 64;  // A mean gains little from more.
constexpr std::size_t kMostKept = 12;

cv::Mat small(const cv::Mat& picture) {
  const int rows = std::min(kSmallRows, picture.rows);
  const int cols = std::max(1, static_cast<int>(std::lround(double(picture.cols) * rows / picture.rows)));
  cv::Mat out;
  cv::resize(picture, out, {cols, rows}, 0, 0, cv::INTER_AREA);
  return out;
}

// How far `now` lies outside what `before` has within one pixel around: a camera that shakes a little is still.
cv::Mat change_beyond_shake(const cv::Mat& before, const cv::Mat& now) {
  const cv::Mat square = cv::getStructuringElement(cv::MORPH_RECT, {3, 3});
  cv::Mat highest;
  cv::Mat lowest;
  cv::dilate(before, highest, square);
  cv::erode(before, lowest, square);
  return difference_luminance(now, cv::max(lowest, cv::min(now, highest)));
}

}  // namespace

void QuietStretches::add(const cv::Mat& picture, double time_s) {
  const cv::Mat now = small(picture);
  bool quiet = count_ > 0;
  if (quiet) {
    const cv::Mat change = change_beyond_shake(ToneCurve(first_small_, now).apply(first_small_), now);
    quiet = cv::countNonZero(change > kChange) <= kQuietShare * double(change.total());
  }
  if (!quiet) {
    end_stretch();
    first_small_ = now;
    begin_s_ = time_s;
    sum_ = cv::Mat::zeros(picture.size(), CV_32SC3);
  }
  if (count_ < kMostSummed) {
    cv::add(sum_, picture, sum_, cv::noArray(), CV_32S);
    ++count_;
  }
  last_s_ = time_s;
}

void QuietStretches::end_stretch() {
  const double length_s = last_s_ - begin_s_;
  if (count_ > 1 && length_s >= kLeastStretch_s) {
    Stretch stretch{length_s, ended_++, {}};
    sum_.convertTo(stretch.mean, CV_8U, 1.0 / count_);
    const auto place =
        std::find_if(found_.begin(), found_.end(), [&](const Stretch& s) { return s.length_s < length_s; });
    found_.insert(place, std::move(stretch));
    if (found_.size() > kMostKept) {
      const auto shortest = std::find_if(found_.rbegin(), found_.rend(),
                                         [&](const Stretch& s) { return s.number != 0 && s.number != ended_ - 1; });
      found_.erase(std::prev(shortest.base()));
    }
  }
  count_ = 0;
}

std::vector<cv::Mat> QuietStretches::finish() {
  end_stretch();
  std::vector<cv::Mat> means;
  for (const auto& stretch : found_) means.push_back(stretch.mean);
  return means;
}

}  // namespace choreo::vision
