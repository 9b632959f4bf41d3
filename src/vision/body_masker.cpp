// SPDX-License-Identifier: Apache-2.0
#include "vision/body_masker.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "core/error.hpp"
#include "vision/background_estimate.hpp"
#include "vision/difference.hpp"

namespace choreo::vision {
namespace {

void check(bool fits, const char* option, double value, const char* range) {
  if (!fits) throw usage_error(fmt::format("{} is {}", option, value), {}, fmt::format("{} is {}", option, range));
}

void check_zone(const Zone& zone, const char* option) {
  const bool fits = zone.x0 >= 0 && zone.x0 < zone.x1 && zone.x1 <= 1 && zone.y0 >= 0 && zone.y0 < zone.y1 && zone.y1 <= 1;
  if (!fits) {
    throw usage_error(fmt::format("{} is [{}, {}, {}, {}]", option, zone.x0, zone.y0, zone.x1, zone.y1), {},
                      fmt::format("{} is [left, top, right, bottom] in fractions of the picture, 0 to 1, left before "
                                  "right and top before bottom", option));
  }
}

cv::Rect pixels_of(const Zone& zone, cv::Size size) {
  const int x0 = static_cast<int>(std::lround(zone.x0 * size.width));
  const int y0 = static_cast<int>(std::lround(zone.y0 * size.height));
  const int x1 = static_cast<int>(std::lround(zone.x1 * size.width));
  const int y1 = static_cast<int>(std::lround(zone.y1 * size.height));
  return {x0, y0, x1 - x0, y1 - y0};
}

// The background in another light: per channel the monotone tone curve that takes it to the picture, from the median
// over the pixels of each range of levels. A body covers too few of them to sway a median.
cv::Mat in_the_light_of(const cv::Mat& background, const cv::Mat& picture) {
  constexpr int kLevels = 16;  // Grey levels a range.
  constexpr int kRanges = 256 / kLevels;
  cv::Mat curves(1, 256, CV_8UC3);
  for (int channel = 0; channel < 3; ++channel) {
    std::vector<std::vector<std::uint8_t>> seen(kRanges);
    for (int y = 0; y < background.rows; ++y) {
      const auto* b = background.ptr<std::uint8_t>(y) + channel;
      const auto* p = picture.ptr<std::uint8_t>(y) + channel;
      for (int x = 0; x < background.cols; ++x) seen[std::size_t(b[3 * x] / kLevels)].push_back(p[3 * x]);
    }
    std::vector<std::pair<double, double>> knots;  // Level before, level after; at the middle of each range.
    const std::size_t enough = std::max<std::size_t>(8, background.total() / 500);
    for (int r = 0; r < kRanges; ++r) {
      auto& values = seen[std::size_t(r)];
      if (values.size() < enough) continue;
      const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
      std::nth_element(values.begin(), middle, values.end());
      const double before = r * kLevels + (kLevels - 1) / 2.0;
      const double least = knots.empty() ? 0.0 : knots.back().second;
      knots.emplace_back(before, std::max(least, double(*middle)));
    }
    for (int level = 0; level < 256; ++level) {
      double after = level;
      if (knots.size() == 1) {
        after = level * knots[0].second / std::max(1.0, knots[0].first);
      } else if (knots.size() > 1) {
        auto right = std::find_if(knots.begin() + 1, knots.end() - 1, [&](const auto& k) { return k.first >= level; });
        const auto left = right - 1;
        after = left->second + (level - left->first) * (right->second - left->second) / (right->first - left->first);
      }
      curves.at<cv::Vec3b>(0, level)[channel] = cv::saturate_cast<std::uint8_t>(after);
    }
  }
  cv::Mat out;
  cv::LUT(background, curves, out);
  return out;
}

}  // namespace

void MaskOptions::validate() const {
  if (threshold) check(*threshold > 0 && *threshold <= 255, "mask.threshold", *threshold, "above 0 and at most 255 grey levels, or \"auto\"");
  check(noise_factor >= 1 && noise_factor <= 20, "mask.noise_factor", noise_factor, "from 1 to 20");
  check(least_threshold >= 1 && least_threshold <= 255, "mask.least_threshold", least_threshold, "from 1 to 255 grey levels");
  check(steps >= 0 && steps <= 32, "mask.steps", steps, "from 0 to 32");
  check(speck_percent >= 0 && speck_percent <= 100, "mask.speck_percent", speck_percent, "from 0 to 100 % of the picture");
  check(min_body_percent >= 0 && min_body_percent <= 100, "mask.min_body_percent", min_body_percent, "from 0 to 100 % of the picture");
  check_zone(roi, "mask.roi");
  for (const auto& zone : ignore) check_zone(zone, "mask.ignore");
  check(follow_s >= 0 && follow_s <= 3600, "background.follow_s", follow_s, "from 0 (off) to 3600 s");
  check(sudden_percent >= 1 && sudden_percent <= 100, "background.sudden_percent", sudden_percent, "from 1 to 100 % of the picture (100: off)");
  check(relearn_s >= 0 && relearn_s <= 60, "background.relearn_s", relearn_s, "from 0 to 60 s");
}

BodyMasker::BodyMasker(const cv::Mat& plate, double noise, MaskOptions options) : options_(std::move(options)) {
  assert(plate.type() == CV_8UC3);
  options_.validate();
  threshold_ = options_.threshold.value_or(std::max(options_.least_threshold, options_.noise_factor * noise));
  background_ = plate.clone();
  background_.convertTo(running_, CV_32F);
  const bool everywhere = options_.roi == Zone{} && options_.ignore.empty();
  if (!everywhere) {
    allowed_ = cv::Mat::zeros(plate.size(), CV_8UC1);
    allowed_(pixels_of(options_.roi, plate.size())) = 255;
    for (const auto& zone : options_.ignore) allowed_(pixels_of(zone, plate.size())) = 0;
  }
}

cv::Mat BodyMasker::raw_mask(const cv::Mat& difference) const { return difference > threshold_; }

MaskResult BodyMasker::process(const cv::Mat& picture, double time_s) {
  assert(picture.type() == CV_8UC3 && picture.size() == background_.size());
  const double dt_s = last_time_s_ ? time_s - *last_time_s_ : 0.0;
  last_time_s_ = time_s;

  MaskResult result;
  result.mask = cv::Mat::zeros(picture.size(), CV_8UC1);
  if (learning_since_s_) {
    result.learning = relearn(picture, time_s);
    if (result.learning) return result;
  }
  cv::Mat difference = difference_luminance(picture, background_);
  cv::Mat mask = raw_mask(difference);
  const double changed_percent = 100.0 * cv::countNonZero(mask) / double(mask.total());
  if (options_.sudden_percent < 100 && changed_percent > options_.sudden_percent) {
    result.sudden = true;
    const cv::Mat relit = in_the_light_of(background_, picture);
    difference = difference_luminance(picture, relit);
    mask = raw_mask(difference);
    if (100.0 * cv::countNonZero(mask) / double(mask.total()) > options_.sudden_percent / 2) {
      // Not the light but the scene: nothing known of the old wall helps.
      learning_since_s_ = time_s;
      learning_.clear();
      result.learning = relearn(picture, time_s);
      return result;
    }
    background_ = relit;
    background_.convertTo(running_, CV_32F);
  }
  if (options_.half_contrast_edge) mask = edge_at_half_contrast(mask, difference);
  mask = annealed(mask, options_.steps);
  if (!allowed_.empty()) mask &= allowed_;
  const int speck = static_cast<int>(std::ceil(options_.speck_percent / 100.0 * double(mask.total())));
  mask = without_specks(mask, speck, options_.largest_only);

  follow(picture, mask, dt_s);

  const int area = cv::countNonZero(mask);
  if (area == 0 || area < options_.min_body_percent / 100.0 * double(mask.total())) return result;
  result.mask = mask;
  result.area = area;
  result.body = true;
  const auto box = cv::boundingRect(mask);
  result.cut = box.x == 0 || box.y == 0 || box.br().x == mask.cols || box.br().y == mask.rows;
  return result;
}

void BodyMasker::follow(const cv::Mat& picture, const cv::Mat& mask, double dt_s) {
  if (options_.follow_s <= 0 || dt_s <= 0) return;
  // The body's shadow and blur reach beyond its mask.
  cv::Mat body;
  const int margin = 2 + picture.rows / 60;
  cv::dilate(mask, body, cv::getStructuringElement(cv::MORPH_RECT, {2 * margin + 1, 2 * margin + 1}));
  const auto rate = static_cast<float>(1.0 - std::exp(-dt_s / options_.follow_s));
  for (int y = 0; y < picture.rows; ++y) {
    const auto* now = picture.ptr<std::uint8_t>(y);
    const auto* skip = body.ptr<std::uint8_t>(y);
    auto* mean = running_.ptr<float>(y);
    auto* rounded = background_.ptr<std::uint8_t>(y);
    for (int x = 0; x < picture.cols; ++x) {
      if (skip[x] != 0) continue;
      for (int i = 3 * x; i < 3 * x + 3; ++i) {
        mean[i] += rate * (float(now[i]) - mean[i]);
        rounded[i] = static_cast<std::uint8_t>(mean[i] + 0.5F);
      }
    }
  }
}

bool BodyMasker::relearn(const cv::Mat& picture, double time_s) {
  constexpr std::size_t kMostPictures = 64;  // Bounds the memory; a median gains nothing from more.
  if (learning_.size() < kMostPictures) learning_.push_back(picture.clone());
  if (time_s - *learning_since_s_ < options_.relearn_s) return true;
  background_ = median_plate(learning_);
  background_.convertTo(running_, CV_32F);
  learning_.clear();
  learning_since_s_.reset();
  return false;
}

}  // namespace choreo::vision
