// SPDX-License-Identifier: Apache-2.0
#include "vision/dynamic_background.hpp"

#include <algorithm>
#include <array>
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

// The pixels of a mask for which something holds.
template <typename Holds>
cv::Mat those_of(const cv::Mat& mask, const Holds& holds) {
  cv::Mat out = cv::Mat::zeros(mask.size(), CV_8UC1);
  tbb::parallel_for(tbb::blocked_range<int>(0, mask.rows, 16), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y) {
      for (int x = 0; x < mask.cols; ++x) {
        if (mask.at<std::uint8_t>(y, x) != 0 && holds(cv::Point(x, y))) out.at<std::uint8_t>(y, x) = 255;
      }
    }
  });
  return out;
}

}  // namespace

SurroundedColours::SurroundedColours(const cv::Mat& picture) : reach_(reach_of(picture.size())) {
  assert(picture.type() == CV_8UC3);
  cv::copyMakeBorder(picture, wider_, reach_, reach_, reach_, reach_, cv::BORDER_REPLICATE);
  for (const auto& p : places_within(reach_)) steps_.push_back(p.y * std::ptrdiff_t(wider_.step) + 3 * p.x);
  const cv::Size squares((picture.cols + kSquare - 1) / kSquare, (picture.rows + kSquare - 1) / kSquare);
  lowest_ = cv::Mat(squares, CV_8UC3, cv::Scalar::all(255));
  highest_ = cv::Mat(squares, CV_8UC3, cv::Scalar());
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const auto& colour = picture.at<cv::Vec3b>(y, x);
      auto& low = lowest_.at<cv::Vec3b>(y / kSquare, x / kSquare);
      auto& high = highest_.at<cv::Vec3b>(y / kSquare, x / kSquare);
      for (int c = 0; c < 3; ++c) low[c] = std::min(low[c], colour[c]), high[c] = std::max(high[c], colour[c]);
    }
  }
  cv::erode(lowest_, lowest_, cv::Mat());
  cv::dilate(highest_, highest_, cv::Mat());
}

bool SurroundedColours::show(const cv::Vec3b& colour, cv::Point at, double threshold) const {
  constexpr std::array kWeights = {114, 587, 299};
  const int most = static_cast<int>(1000 * threshold) + 500;  // D is rounded.
  const auto& low = lowest_.at<cv::Vec3b>(at.y / kSquare, at.x / kSquare);
  const auto& high = highest_.at<cv::Vec3b>(at.y / kSquare, at.x / kSquare);
  for (int c = 0; c < 3; ++c) {
    if (kWeights[c] * std::max(low[c] - colour[c], colour[c] - high[c]) >= most) return false;
  }
  const auto* const middle = wider_.ptr<std::uint8_t>(at.y + reach_, at.x + reach_);
  return std::ranges::any_of(steps_, [&](std::ptrdiff_t step) {
    const auto apart = [&](int c) { return kWeights[c] * std::abs(colour[c] - middle[step + c]); };
    return apart(0) + apart(1) + apart(2) < most;
  });
}

cv::Mat displaced(const cv::Mat& mask, const cv::Mat& picture, const cv::Mat& wall, double threshold) {
  assert(wall.size() == picture.size() && mask.size() == picture.size());
  const SurroundedColours about(wall);
  return those_of(mask, [&](cv::Point p) { return about.show(picture.at<cv::Vec3b>(p), p, threshold); });
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
  for (std::size_t k = 0; k < count; ++k) looks_.emplace_back(pictures[chosen(k)]);
}

double DynamicBackground::share() const {
  return area_.empty() ? 0.0 : double(cv::countNonZero(area_)) / double(area_.total());
}

cv::Mat DynamicBackground::without(const cv::Mat& mask, const cv::Mat& picture, const cv::Mat& background,
                                   double threshold) const {
  if (area_.empty()) return mask;
  const auto known = looks_.size() / 3;
  const SurroundedColours wall(background);
  const cv::Mat did_before = those_of(mask & area_, [&](cv::Point p) {
    const auto& colour = picture.at<cv::Vec3b>(p);
    if (wall.show(colour, p, threshold)) return true;
    std::size_t times = 0;
    for (std::size_t k = 0; times < known && times + looks_.size() - k >= known; ++k) {
      times += looks_[k].show(colour, p, threshold) ? 1 : 0;
    }
    return times >= known;
  });
  return mask & ~did_before;
}

}  // namespace choreo::vision
