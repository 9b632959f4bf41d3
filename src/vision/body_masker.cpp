// SPDX-License-Identifier: Apache-2.0
#include "vision/body_masker.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <opencv2/imgproc.hpp>

#include "core/error.hpp"
#include "vision/difference.hpp"
#include "vision/soft_light.hpp"
#include "vision/tone_curve.hpp"

namespace choreo::vision {
namespace {

void check(bool fits, const char* option, double value, const char* range) {
  if (!fits) throw usage_error(fmt::format("{} is {}", option, value), {}, fmt::format("{} is {}", option, range));
}

void check_zone(const Zone& zone, const char* option) {
  if (!zone.valid()) {
    throw usage_error(fmt::format("{} is [{}, {}, {}, {}]", option, zone.x0, zone.y0, zone.x1, zone.y1), {},
                      fmt::format("{} is [left, top, right, bottom] in fractions of the picture, 0 to 1, left before "
                                  "right and top before bottom",
                                  option));
  }
}

// Moves the running mean of `count` channels towards what differs from the expected, and rounds it.
void learn(const std::uint8_t* __restrict now, const std::uint8_t* __restrict expected, float* __restrict mean,
           std::uint8_t* __restrict rounded, int count, float rate) {
  for (int i = 0; i < count; ++i) {
    const float moved = mean[i] + rate * static_cast<float>(int{now[i]} - int{expected[i]});
    const float positive = moved > 0.0F ? moved : 0.0F;
    mean[i] = positive < 255.0F ? positive : 255.0F;
    rounded[i] = static_cast<std::uint8_t>(static_cast<int>(mean[i] + 0.5F));
  }
}

// Grown by a square; only around what is set.
cv::Mat dilated(const cv::Mat& mask, int margin) {
  cv::Mat out = cv::Mat::zeros(mask.size(), CV_8UC1);
  const auto box = cv::boundingRect(mask);
  if (box.empty()) return out;
  const auto grown = cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
                     cv::Rect({0, 0}, mask.size());
  cv::Mat part = out(grown);
  cv::dilate(mask(grown), part, cv::getStructuringElement(cv::MORPH_RECT, {2 * margin + 1, 2 * margin + 1}));
  return out;
}

// A header of them.
cv::Mat every_fourth_row(const cv::Mat& picture) {
  return {(picture.rows + 3) / 4, picture.cols, picture.type(), picture.data, 4 * picture.step};
}

cv::Rect pixels_of(const Zone& zone, cv::Size size) {
  const int x0 = static_cast<int>(std::lround(zone.x0 * size.width));
  const int y0 = static_cast<int>(std::lround(zone.y0 * size.height));
  const int x1 = static_cast<int>(std::lround(zone.x1 * size.width));
  const int y1 = static_cast<int>(std::lround(zone.y1 * size.height));
  return {x0, y0, x1 - x0, y1 - y0};
}

BackgroundEstimate known(const cv::Mat& plate, double noise) {
  BackgroundEstimate estimate;
  estimate.plate = plate;
  estimate.noise = noise;
  return estimate;
}

}  // namespace

void MaskOptions::validate() const {
  if (threshold)
    check(*threshold > 0 && *threshold <= 255, "mask.threshold", *threshold,
          "above 0 and at most 255 grey levels, or \"auto\"");
  check(noise_factor >= 1 && noise_factor <= 20, "mask.noise_factor", noise_factor, "from 1 to 20");
  check(least_threshold >= 1 && least_threshold <= 255, "mask.least_threshold", least_threshold,
        "from 1 to 255 grey levels");
  check(steps >= 0 && steps <= 32, "mask.steps", steps, "from 0 to 32");
  check(speck_percent >= 0 && speck_percent <= 100, "mask.speck_percent", speck_percent,
        "from 0 to 100 % of the picture");
  check(min_body_percent >= 0 && min_body_percent <= 100, "mask.min_body_percent", min_body_percent,
        "from 0 to 100 % of the picture");
  check_zone(roi, "mask.roi");
  for (const auto& zone : ignore) check_zone(zone, "mask.ignore");
  check(follow_s >= 0 && follow_s <= 3600, "background.follow_s", follow_s, "from 0 (off) to 3600 s");
  check(sudden_percent >= 1 && sudden_percent <= 100, "background.sudden_percent", sudden_percent,
        "from 1 to 100 % of the picture (100: off)");
  check(absorb_s >= 0 && absorb_s <= 3600, "background.absorb_s", absorb_s, "from 0 (never) to 3600 s");
  check(relearn_s >= 0 && relearn_s <= 60, "background.relearn_s", relearn_s, "from 0 to 60 s");
}

cv::Mat allowed_area(const MaskOptions& options, cv::Size size) {
  if (options.roi == Zone{} && options.ignore.empty()) return {};
  cv::Mat allowed = cv::Mat::zeros(size, CV_8UC1);
  allowed(pixels_of(options.roi, size)) = 255;
  for (const auto& zone : options.ignore) allowed(pixels_of(zone, size)) = 0;
  return allowed;
}

BodyMasker::BodyMasker(const cv::Mat& plate, double noise, MaskOptions options)
    : BodyMasker(known(plate, noise), std::move(options)) {}

BodyMasker::BodyMasker(const BackgroundEstimate& estimate, MaskOptions options) : options_(std::move(options)) {
  const auto& plate = estimate.plate;
  assert(plate.type() == CV_8UC3);
  options_.validate();
  threshold_ = options_.threshold.value_or(std::max(options_.least_threshold, options_.noise_factor * estimate.noise));
  background_ = plate.clone();
  background_.convertTo(running_, CV_32F);
  dynamic_ = estimate.dynamic;
  allowed_ = allowed_area(options_, plate.size());
}

double BodyMasker::changed_percent(const cv::Mat& difference) const {
  return 100.0 * cv::countNonZero(difference > threshold_) / double(difference.total());
}

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
  ToneCurve curve;
  tbb::parallel_invoke(
      [&] {
        // A change of light is seen against the light of the last picture, before it is made up for.
        result.sudden = options_.sudden_percent < 100 && !last_lit_.empty() &&
                        changed_percent(difference_luminance(every_fourth_row(picture), every_fourth_row(last_lit_))) >
                            options_.sudden_percent;
      },
      [&] {
        // What the body covers would bend the curve.
        if (options_.follow_exposure) curve = ToneCurve(background_, picture, last_mask_);
      });
  // After a sudden change nobody knows where the body is.
  constexpr int kAnyChange = 255;
  if (result.sudden) curve = ToneCurve(background_, picture, {}, kAnyChange);
  const cv::Mat lit = curve.apply(background_);
  const cv::Mat difference = difference_luminance(picture, lit);
  if (result.sudden) {
    if (changed_percent(difference) > options_.sudden_percent / 2) {
      // Not the light but the scene: nothing known of the old wall helps.
      learning_since_s_ = time_s;
      result.learning = relearn(picture, time_s);
      return result;
    }
    background_ = lit.clone();  // The lit one is kept beside it.
    background_.convertTo(running_, CV_32F);
  }
  cv::Mat mask = dynamic_.without(difference > threshold_, picture, lit, threshold_);
  if (options_.drop_soft_light) mask = without_soft_light(mask, picture, lit);
  if (options_.half_contrast_edge) mask = edge_at_half_contrast(without_halo(mask, difference), difference);
  mask = annealed(mask, options_.steps);
  if (!allowed_.empty()) mask &= allowed_;
  const int speck = static_cast<int>(std::ceil(options_.speck_percent / 100.0 * double(mask.total())));
  mask = without_specks(mask, speck, options_.largest_only);

  // The body's shadow and blur reach beyond its mask.
  const int margin = 2 + picture.rows / 60;
  last_mask_ = dilated(mask, margin);
  // The mean of leaf and sky is neither.
  if (!dynamic_.area().empty()) last_mask_ |= dynamic_.area() & (difference > threshold_);
  last_lit_ = lit;
  follow(picture, lit, dt_s);
  if (options_.absorb_s > 0) absorb(picture, mask, time_s);

  const int area = cv::countNonZero(mask);
  if (area == 0 || area < options_.min_body_percent / 100.0 * double(mask.total())) return result;
  result.mask = mask;
  result.area = area;
  result.body = true;
  const auto box = cv::boundingRect(mask);
  result.cut = box.x == 0 || box.y == 0 || box.br().x == mask.cols || box.br().y == mask.rows;
  return result;
}

void BodyMasker::follow(const cv::Mat& picture, const cv::Mat& lit, double dt_s) {
  if (options_.follow_s <= 0 || dt_s <= 0) return;
  // Slow light can wait: each picture moves so many rows that none of them moves by more than a twentieth.
  constexpr double kMostAtOnce = 1.0 / 20;
  const int turns = int(std::clamp(kMostAtOnce * options_.follow_s / dt_s, 1.0, 8.0));
  const int turn = int(turn_++) % turns;
  const auto rate = static_cast<float>(1.0 - std::exp(-turns * dt_s / options_.follow_s));
  const auto follow_row = [&](int y) {
    const auto* now = picture.ptr<std::uint8_t>(y);
    const auto* expected = lit.ptr<std::uint8_t>(y);
    const auto* skip = last_mask_.ptr<std::uint8_t>(y);
    auto* mean = running_.ptr<float>(y);
    auto* rounded = background_.ptr<std::uint8_t>(y);
    // In runs between the bodies: their inner loop becomes vector code.
    for (int begin = 0; begin < picture.cols;) {
      if (skip[begin] != 0) {
        ++begin;
        continue;
      }
      const auto left = std::size_t(picture.cols - begin);
      const auto* run_end = static_cast<const std::uint8_t*>(std::memchr(skip + begin, 255, left));
      const int end = run_end == nullptr ? picture.cols : static_cast<int>(run_end - skip);
      learn(now + 3 * begin, expected + 3 * begin, mean + 3 * begin, rounded + 3 * begin, 3 * (end - begin), rate);
      begin = end;
    }
  };
  for (int y = turn; y < picture.rows; y += turns) follow_row(y);
}

// Whole parts of the mask that did not move: somebody who only moves an arm stays as they are.
void BodyMasker::absorb(const cv::Mat& picture, const cv::Mat& mask, double time_s) {
  if (still_.empty()) {
    still_ = mask.clone();
    still_looks_ = picture.clone();
    still_since_s_ = time_s;
    return;
  }
  // What light does to both is no movement.
  still_ &= difference_luminance(picture, still_looks_) <= 2 * threshold_;
  if (time_s - still_since_s_ < options_.absorb_s) return;
  constexpr double kAllOfIt = 0.95;
  cv::Mat labels;
  const int count = cv::connectedComponents(mask, labels, 8, CV_32S, cv::CCL_SAUF);
  cv::Mat absorbed = cv::Mat::zeros(mask.size(), CV_8UC1);
  for (int part = 1; part < count; ++part) {
    const cv::Mat all = labels == part;
    if (cv::countNonZero(all & still_) >= kAllOfIt * cv::countNonZero(all)) absorbed |= all;
  }
  if (cv::countNonZero(absorbed) > 0) {
    absorbed = dilated(absorbed, 2);  // With the blur of its edge.
    picture.copyTo(background_, absorbed);
    background_.convertTo(running_, CV_32F);
    last_mask_.setTo(0, absorbed);
  }
  still_ = mask & ~absorbed;
  still_looks_ = picture.clone();
  still_since_s_ = time_s;
}

bool BodyMasker::relearn(const cv::Mat& picture, double time_s) {
  constexpr std::size_t kMostPictures = 64;  // Bounds the memory; a median gains nothing from more.
  if (learning_.size() < kMostPictures) learning_.push_back(picture.clone());
  if (time_s - *learning_since_s_ < options_.relearn_s) return true;
  background_ = median_plate(learning_);
  background_.convertTo(running_, CV_32F);
  const std::vector<cv::Mat> same(learning_.size(), background_);
  dynamic_ = DynamicBackground(learning_, same, threshold_);
  last_mask_ = cv::Mat();
  // Should the scene have changed again meanwhile, the next picture is seen to be another.
  last_lit_ = background_.clone();
  learning_.clear();
  learning_since_s_.reset();
  return false;
}

}  // namespace choreo::vision
