// SPDX-License-Identifier: Apache-2.0
#include "vision/dynamic_background.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <opencv2/imgproc.hpp>

#include "vision/difference.hpp"

namespace choreo::vision {
namespace {

int reach_of(cv::Size size) { return std::clamp(cvRound(size.height / 40.0), 3, 8); }

// The nearest first: most that is displaced is so by little.
std::vector<cv::Point> places_within(int reach) {
  std::vector<cv::Point> places;
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      if (const cv::Point p(x, y); p.dot(p) > 0 && p.dot(p) <= reach * reach) places.push_back(p);
    }
  }
  std::ranges::stable_sort(places, {}, [](const auto& p) { return p.dot(p); });
  return places;
}

// Whether what differs comes and goes from picture to picture. Somebody stays for some pictures on end: of n, of which
// d differ, half as many changes as chance would make, 2 d (n - d) / n, are too many for them.
cv::Mat changes_by_chance(const cv::Mat& changes, const cv::Mat& differing, int n) {
  cv::Mat d;
  differing.convertTo(d, CV_32F);
  const cv::Mat half = d.mul(n - d) / n;
  cv::Mat changed;
  changes.convertTo(changed, CV_32F);
  constexpr int kLeast = 3;  // Who comes and goes once makes two.
  return (changed >= half) & (changes >= kLeast);
}

// Where a third of the pixels about are set: the edges of what passes are thin, and leaves are everywhere.
cv::Mat dense(const cv::Mat& set) {
  constexpr double kDense = 0.35;
  const int side = 4 * reach_of(set.size()) + 1;
  cv::Mat share;
  cv::boxFilter(set & 1, share, CV_32F, {side, side}, {-1, -1}, true, cv::BORDER_REFLECT);
  return share >= kDense;
}

}  // namespace

cv::Mat displaced(const cv::Mat& mask, const cv::Mat& picture, const cv::Mat& wall, double threshold) {
  assert(picture.type() == CV_8UC3 && wall.size() == picture.size() && mask.size() == picture.size());
  const auto places = places_within(reach_of(mask.size()));
  const cv::Rect whole({0, 0}, mask.size());
  const int most = static_cast<int>(1000 * threshold) + 500;  // D is rounded.
  cv::Mat out = cv::Mat::zeros(mask.size(), CV_8UC1);
  tbb::parallel_for(tbb::blocked_range<int>(0, mask.rows, 16), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y) {
      for (int x = 0; x < mask.cols; ++x) {
        if (mask.at<std::uint8_t>(y, x) == 0) continue;
        const auto& here = picture.at<cv::Vec3b>(y, x);
        const auto alike = [&](const cv::Point& away) {
          const cv::Point there = cv::Point(x, y) + away;
          if (!whole.contains(there)) return false;
          const auto& beside = wall.at<cv::Vec3b>(there);
          const int difference = 114 * std::abs(here[0] - beside[0]) + 587 * std::abs(here[1] - beside[1]) +
                                 299 * std::abs(here[2] - beside[2]);
          return difference < most;
        };
        if (std::ranges::any_of(places, alike)) out.at<std::uint8_t>(y, x) = 255;
      }
    }
  });
  return out;
}

DynamicBackground::DynamicBackground(std::span<const cv::Mat> pictures, std::span<const cv::Mat> backgrounds,
                                     double threshold) {
  assert(!pictures.empty() && pictures.size() == backgrounds.size());
  constexpr std::size_t kPictures = 24, kLeast = 8;
  const auto count = std::min(pictures.size(), kPictures);
  if (count < kLeast) return;
  // Not evenly: a bough that swings in step with them would seem to stay.
  const auto chosen = [&](std::size_t k) {
    constexpr double kGolden = 0.618033988749895;
    const double aside = double(k) * kGolden - std::floor(double(k) * kGolden);
    return std::size_t((double(k) + aside) * double(pictures.size()) / double(count));
  };
  const auto size = pictures.front().size();
  std::vector<cv::Mat> differs;
  cv::Mat differing = cv::Mat::zeros(size, CV_8UC1), changes = differing.clone();
  for (std::size_t k = 0; k < count; ++k) {
    differs.emplace_back(difference_luminance(pictures[chosen(k)], backgrounds[chosen(k)]) > threshold);
    differing += differs[k] & 1;
    if (k > 0) changes += (differs[k] ^ differs[k - 1]) & 1;
  }
  const cv::Mat comes_and_goes = changes_by_chance(changes, differing, int(count));
  const int often = int(count) / 4;
  const cv::Mat may_be = dense(comes_and_goes & (differing >= often));
  if (cv::countNonZero(may_be) == 0) return;
  cv::Mat times = cv::Mat::zeros(size, CV_8UC1);
  for (std::size_t k = 0; k < count; ++k) {
    times += displaced(differs[k] & may_be, pictures[chosen(k)], backgrounds[chosen(k)], threshold) & 1;
  }
  const cv::Mat area = dense(comes_and_goes & (times >= often));
  if (cv::countNonZero(area) == 0) return;
  const int side = 2 * reach_of(size) + 1;
  cv::dilate(area, area_, cv::getStructuringElement(cv::MORPH_RECT, {side, side}));
  area_.setTo(0, (differing >= int(count) / 8) & ~comes_and_goes);
  for (std::size_t k = 0; k < count; ++k) {
    looks_.push_back(pictures[chosen(k)].clone());
    for (const auto& shown : {looks_.back(), backgrounds[chosen(k)]}) {
      if (lowest_.empty()) lowest_ = shown.clone(), highest_ = shown.clone();
      cv::min(lowest_, shown, lowest_);
      cv::max(highest_, shown, highest_);
    }
  }
  const cv::Mat about = cv::getStructuringElement(cv::MORPH_RECT, {side, side});
  cv::erode(lowest_, lowest_, about);
  cv::dilate(highest_, highest_, about);
  // Of a colour that is alike no channel is farther off.
  const cv::Scalar most((1000 * threshold + 500) / 114, (1000 * threshold + 500) / 587, (1000 * threshold + 500) / 299);
  cv::subtract(lowest_, most, lowest_);
  cv::add(highest_, most, highest_);
}

double DynamicBackground::share() const {
  return area_.empty() ? 0.0 : double(cv::countNonZero(area_)) / double(area_.total());
}

cv::Mat DynamicBackground::without(const cv::Mat& mask, const cv::Mat& picture, const cv::Mat& background,
                                   double threshold) const {
  if (area_.empty()) return mask;
  const int known = int(looks_.size()) / 3;
  cv::Mat left = mask & area_;
  left &= ~displaced(left, picture, background, threshold);
  // Most of a body has a colour that was never about: nothing more is to be searched for.
  cv::Mat within;
  cv::inRange(picture, lowest_, highest_, within);
  const cv::Mat others = (mask & ~area_) | (left & ~within);
  left &= within;
  cv::Mat times = cv::Mat::zeros(mask.size(), CV_8UC1);
  cv::Mat kept = cv::Mat::zeros(mask.size(), CV_8UC1);
  for (std::size_t k = 0; k < looks_.size(); ++k) {
    times += displaced(left, picture, looks_[k], threshold) & 1;
    left.setTo(0, times >= known);
    // Too few are to come.
    const cv::Mat hopeless = left & (times + double(looks_.size() - k - 1) < known);
    kept |= hopeless;
    left &= ~hopeless;
  }
  return others | kept | left;
}

}  // namespace choreo::vision
