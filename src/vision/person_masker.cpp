// SPDX-License-Identifier: Apache-2.0
#include "vision/person_masker.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <opencv2/imgproc.hpp>

#include "vision/difference.hpp"
#include "vision/soft_light.hpp"
#include "vision/tone_curve.hpp"

namespace choreo::vision {
namespace {

constexpr double kLikely = 127;        // Of 255: more likely a person's than not.
constexpr double kPossible = 25;       // One in ten.
constexpr double kEntersWithin = 0.5;  // Seconds; of a body half of which is in the picture the network knows.
constexpr double kFollowedFor = 3;     // Seconds, by the difference alone.
constexpr double kReach = 1 / 60.0;    // Of the picture's height: hair, a held fan, what the silhouette rounds off.

cv::Mat square(double px) {
  const int side = 2 * int(std::lround(px)) + 1;
  return cv::getStructuringElement(cv::MORPH_RECT, {side, side});
}

// Everything that may be the person's.
cv::Mat possible(const PersonEvidence& person, cv::Size size) {
  if (person.likely.empty()) return cv::Mat::zeros(size, CV_8UC1);
  cv::Mat out;
  cv::dilate(person.likely > kPossible, out, square(person.doubt_px + kReach * size.height));
  for (const auto& reach : person.held) {
    const cv::Point hand(cvRound(reach.hand.x), cvRound(reach.hand.y));
    cv::circle(out, hand, cvRound(reach.radius + person.doubt_px), 255, cv::FILLED);
  }
  return out;
}

// The pictures in which nobody is seen, but soon before or after: the network lost somebody, and they tell nothing.
std::vector<std::size_t> lost(std::span<const PersonEvidence> people) {
  constexpr std::size_t kLeft = 3;  // So many in a row show a room that was left.
  std::vector<std::size_t> out;
  for (std::size_t begin = 0; begin < people.size();) {
    auto end = begin;
    while (end < people.size() && people[end].likely.empty()) ++end;
    if (end - begin < kLeft && end - begin < people.size()) {
      for (auto k = begin; k < end; ++k) out.push_back(k);
    }
    begin = std::max(end, begin + 1);
  }
  return out;
}

}  // namespace

BackgroundEstimate background_behind_people(std::span<const cv::Mat> pictures, std::span<const PersonEvidence> people) {
  assert(!pictures.empty() && pictures.size() == people.size());
  const auto size = pictures.front().size();
  std::vector<cv::Mat> covered;
  for (const auto& person : people) covered.push_back(possible(person, size));
  for (const auto k : lost(people)) covered[k].setTo(255);
  const auto middle = pictures.size() / 2;
  std::vector<cv::Mat> alike;
  for (std::size_t k = 0; k < pictures.size(); ++k) {
    // What somebody covers would bend the curve.
    alike.push_back(ToneCurve(pictures[k], pictures[middle], covered[k] | covered[middle]).apply(pictures[k]));
  }
  cv::Mat plate(size, CV_8UC3);
  cv::Mat never_seen = cv::Mat::zeros(size, CV_8UC1);
  tbb::parallel_for(tbb::blocked_range<int>(0, size.height), [&](const tbb::blocked_range<int>& rows) {
    std::vector<std::uint8_t> values;
    std::vector<std::size_t> free;
    for (int y = rows.begin(); y < rows.end(); ++y) {
      auto* out = plate.ptr<std::uint8_t>(y);
      for (int x = 0; x < size.width; ++x) {
        free.clear();
        for (std::size_t k = 0; k < alike.size(); ++k) {
          if (covered[k].at<std::uint8_t>(y, x) == 0) free.push_back(k);
        }
        // A silhouette that lacks a sleeve now and then is no look at the wall.
        if (free.size() <= alike.size() / 20) {
          never_seen.at<std::uint8_t>(y, x) = 255;
          free.resize(alike.size());
          std::iota(free.begin(), free.end(), std::size_t{0});
        }
        for (int c = 0; c < 3; ++c) {
          values.clear();
          for (const auto k : free) values.push_back(alike[k].ptr<std::uint8_t>(y)[3 * x + c]);
          const auto median = values.begin() + std::ptrdiff_t(values.size() / 2);
          std::ranges::nth_element(values, median);
          out[3 * x + c] = *median;
        }
      }
    }
  });
  auto estimate = judge_plate(plate, pictures);
  estimate.never_seen = never_seen;
  // Of the bodies, by the network's word, what stands before it.
  double bodies = 0, unseen = 0;
  int empty = 0;
  for (const auto& person : people) {
    if (person.likely.empty()) {
      ++empty;
      continue;
    }
    const cv::Mat body = person.likely > kLikely;
    bodies += cv::countNonZero(body);
    unseen += cv::countNonZero(body & never_seen);
  }
  estimate.unseen = bodies > 0 ? unseen / bodies : 0;
  estimate.empty = double(empty) / double(people.size());
  return estimate;
}

PersonMasker::PersonMasker(const BackgroundEstimate& estimate, MaskOptions options) : options_(std::move(options)) {
  assert(estimate.plate.type() == CV_8UC3);
  options_.validate();
  threshold_ = options_.threshold.value_or(std::max(options_.least_threshold, options_.noise_factor * estimate.noise));
  background_ = estimate.plate.clone();
  background_.convertTo(running_, CV_32F);
  never_seen_ = estimate.never_seen.empty() ? cv::Mat::zeros(background_.size(), CV_8UC1) : estimate.never_seen.clone();
  allowed_ = allowed_area(options_, background_.size());
}

// Where the person may be: near what the network saw, or, where it lost them a moment ago, near where they were.
cv::Mat PersonMasker::expected(const PersonEvidence& person, double time_s) const {
  if (!person.likely.empty() || last_mask_.empty() || !last_seen_s_ || time_s - *last_seen_s_ > kFollowedFor) {
    return possible(person, background_.size());
  }
  cv::Mat out;
  cv::dilate(last_mask_, out, square(2 * kReach * background_.rows));
  return out;
}

cv::Mat PersonMasker::foreground(const cv::Mat& picture, const cv::Mat& lit, const cv::Mat& difference) const {
  cv::Mat mask = difference > threshold_;
  if (options_.drop_soft_light) mask = without_soft_light(mask, picture, lit);
  if (options_.half_contrast_edge) mask = edge_at_half_contrast(without_halo(mask, difference), difference);
  return mask;
}

// Large parts at the picture's border, as long as they may be somebody who comes in.
cv::Mat PersonMasker::entering(const cv::Mat& foreground, double time_s) {
  cv::Mat labels, statistics, centroids;
  const int count =
      cv::connectedComponentsWithStats(foreground, labels, statistics, centroids, 8, CV_32S, cv::CCL_SAUF);
  cv::Mat out = cv::Mat::zeros(foreground.size(), CV_8UC1);
  bool any = false;
  for (int part = 1; part < count; ++part) {
    const cv::Rect box(statistics.at<int>(part, cv::CC_STAT_LEFT), statistics.at<int>(part, cv::CC_STAT_TOP),
                       statistics.at<int>(part, cv::CC_STAT_WIDTH), statistics.at<int>(part, cv::CC_STAT_HEIGHT));
    const bool at_side = box.x == 0 || box.br().x == foreground.cols;
    const int area = statistics.at<int>(part, cv::CC_STAT_AREA);
    if (!at_side || area < options_.min_body_percent / 100.0 * double(foreground.total())) continue;
    out.setTo(255, labels == part);
    any = true;
  }
  if (!any) entering_s_.reset();
  if (any && !entering_s_) entering_s_ = time_s;
  if (any && time_s - *entering_s_ > kEntersWithin) out.setTo(0);
  return out;
}

MaskResult PersonMasker::process(const cv::Mat& picture, const PersonEvidence& person, double time_s) {
  assert(picture.type() == CV_8UC3 && picture.size() == background_.size());
  const double dt_s = last_time_s_ ? time_s - *last_time_s_ : 0.0;
  last_time_s_ = time_s;
  MaskResult result;
  result.mask = cv::Mat::zeros(picture.size(), CV_8UC1);

  cv::Mat near = expected(person, time_s);
  ToneCurve curve;
  if (options_.follow_exposure) curve = ToneCurve(background_, picture, near | never_seen_);
  cv::Mat lit = curve.apply(background_);
  cv::Mat difference = difference_luminance(picture, lit);
  if (options_.sudden_percent < 100) {
    const cv::Mat beside = ~(near | never_seen_);
    const double changed = cv::countNonZero((difference > threshold_) & beside);
    if (changed > options_.sudden_percent / 100 * cv::countNonZero(beside) && changed > 0) {
      // Another scene: all that is known of it is what stands beside the person now.
      result.sudden = true;
      near = possible(person, picture.size());
      background_ = picture.clone();
      background_.convertTo(running_, CV_32F);
      never_seen_ = near.clone();
      last_mask_.release();
      lit = background_;
      difference = cv::Mat::zeros(picture.size(), CV_8UC1);
    }
  }
  cv::Mat mask = foreground(picture, lit, difference);
  if (cv::countNonZero(near) == 0) {
    const cv::Mat comes = entering(annealed(mask & ~never_seen_, options_.steps), time_s);
    cv::dilate(comes, near, square(kReach * picture.rows));
  } else {
    entering_s_.reset();
  }
  if (cv::countNonZero(near) > 0) {
    mask &= near;
    if (!person.likely.empty()) {
      const cv::Mat likely = person.likely > kLikely;
      cv::Mat sure;
      cv::erode(likely, sure, square(person.doubt_px), {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(255));
      mask |= sure;
      likely.copyTo(mask, never_seen_);
      last_seen_s_ = time_s;
    } else if (!last_mask_.empty()) {
      last_mask_.copyTo(mask, never_seen_);
    }
    mask = annealed(mask, options_.steps);
    if (!allowed_.empty()) mask &= allowed_;
    const int speck = static_cast<int>(std::ceil(options_.speck_percent / 100.0 * double(mask.total())));
    mask = without_specks(mask, speck, options_.largest_only);
    const int area = cv::countNonZero(mask);
    if (area > 0 && area >= options_.min_body_percent / 100.0 * double(mask.total())) {
      result.mask = mask;
      result.area = area;
      result.inferred = cv::countNonZero(mask & never_seen_);
      result.body = true;
      const auto box = cv::boundingRect(mask);
      result.cut = box.x == 0 || box.y == 0 || box.br().x == mask.cols || box.br().y == mask.rows;
    }
  }
  last_mask_ = result.body ? result.mask : cv::Mat();
  // Who is not seen may stand there all the same, for a while: nothing comes to light but beside somebody who is seen.
  if (!first_time_s_) first_time_s_ = time_s;
  const bool known = !person.likely.empty() || time_s - last_seen_s_.value_or(*first_time_s_) > kFollowedFor;
  learn(picture, lit, known ? cv::Mat(~near) : cv::Mat(~(near | never_seen_)), dt_s);
  return result;
}

// In the light of the plate, as far as the difference tells.
void PersonMasker::learn(const cv::Mat& picture, const cv::Mat& lit, const cv::Mat& surely_not, double dt_s) {
  const cv::Mat first = surely_not & never_seen_;
  if (cv::countNonZero(first) > 0) {
    picture.copyTo(background_, first);
    cv::Mat now;
    picture.convertTo(now, CV_32F);
    now.copyTo(running_, first);
    never_seen_.setTo(0, first);
  }
  if (options_.follow_s <= 0 || dt_s <= 0) return;
  const auto rate = static_cast<float>(1.0 - std::exp(-dt_s / options_.follow_s));
  cv::Mat change = cv::Mat::zeros(picture.size(), CV_32FC3);
  cv::subtract(picture, lit, change, surely_not & ~first, CV_32F);
  cv::scaleAdd(change, rate, running_, running_);
  running_.convertTo(background_, CV_8U);
}

}  // namespace choreo::vision
