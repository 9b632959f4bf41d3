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

constexpr double kLikely = 127;      // Of 255: more likely a person's than not.
constexpr double kSure = 191;        // Three to one, which outweighs what was seen there.
constexpr double kEntersWithin = 1;  // Seconds; of a body half of which is in the picture the network knows.
constexpr double kFollowedFor = 3;   // Seconds, by the difference alone.
constexpr std::uint8_t kKnown = 5;   // Looks in a row that show what was never seen: a sleeve is lacking for some.
constexpr std::uint8_t kYoung = 60;  // Looks during which it is learned quickly,
constexpr std::uint8_t kMean = 10;   // as the mean of about so many.

cv::Mat square(double px) {
  const int side = 2 * int(std::lround(px)) + 1;
  return cv::getStructuringElement(cv::MORPH_RECT, {side, side});
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
  const auto lost_ones = lost(people);
  for (const auto k : lost_ones) covered[k].setTo(255);
  const auto nobody =
      std::size_t(std::ranges::count_if(people, [](const auto& person) { return person.likely.empty(); }));
  const bool was_empty = nobody > lost_ones.size();
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
        // A silhouette that lacks a sleeve now and then is no look at the wall; a room with nobody in it is one.
        if (!was_empty && free.size() <= alike.size() / 20) {
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
  BackgroundEstimate estimate;
  estimate.plate = plate;
  estimate.noise = noise_before(plate, pictures);
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

// Whether what the network took for a person is the room, the foot of a table say: nearly nothing of it differs from
// what was seen there. Of somebody in clothes like the wall the face and the hands do.
bool PersonMasker::is_the_room(const PersonEvidence& person, const cv::Mat& foreground) const {
  constexpr double kLeastThatDiffers = 1.0 / 20;
  if (person.likely.empty()) return false;
  const cv::Mat likely = person.likely > kLikely;
  const cv::Mat seen = likely & ~never_seen_;
  const int known = cv::countNonZero(seen);
  return 2 * known > cv::countNonZero(likely) && cv::countNonZero(foreground & seen) < kLeastThatDiffers * known;
}

// Where the difference has no word the network has it.
cv::Mat PersonMasker::with_the_networks_word(const cv::Mat& foreground, const PersonEvidence& person) const {
  cv::Mat mask = foreground;
  if (person.likely.empty()) {
    if (!last_mask_.empty()) last_mask_.copyTo(mask, never_seen_);
    return mask;
  }
  const cv::Mat likely = person.likely > kLikely;
  cv::Mat sure, silent;
  cv::erode(person.likely > kSure, sure, square(person.doubt_px), {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(255));
  // What says nothing of a sleeve says nothing of its outline either.
  cv::Mat limbs = cv::Mat::zeros(mask.size(), CV_8UC1);
  draw(person.limbs, person.doubt_px, limbs);
  cv::morphologyEx(sure & ~mask, silent, cv::MORPH_OPEN, square(person.doubt_px / 2));
  cv::dilate(silent, silent, square(person.doubt_px));
  mask |= sure | (likely & silent & limbs);
  likely.copyTo(mask, never_seen_);
  return mask;
}

PersonMasker::PersonMasker(const BackgroundEstimate& estimate, MaskOptions options) : options_(std::move(options)) {
  assert(estimate.plate.type() == CV_8UC3);
  options_.validate();
  threshold_ = options_.threshold.value_or(std::max(options_.least_threshold, options_.noise_factor * estimate.noise));
  background_ = estimate.plate.clone();
  background_.convertTo(running_, CV_32F);
  never_seen_ = estimate.never_seen.empty() ? cv::Mat::zeros(background_.size(), CV_8UC1) : estimate.never_seen.clone();
  free_looks_ = cv::Mat(background_.size(), CV_8UC1, cv::Scalar(kYoung));
  free_looks_.setTo(0, never_seen_);
  lately_ = cv::Mat::zeros(background_.size(), CV_8UC1);
  allowed_ = allowed_area(options_, background_.size());
}

// Where the person may be: near what the network saw, and, where it lost them a moment ago or does not see all of who
// comes in, near where they were.
cv::Mat PersonMasker::expected(const PersonEvidence& person, double time_s) const {
  cv::Mat out = possible(person, background_.size());
  const bool lost = person.likely.empty() && last_seen_s_ && time_s - *last_seen_s_ <= kFollowedFor;
  const bool comes = entering_s_ && time_s - *entering_s_ <= kEntersWithin;
  if ((!lost && !comes) || last_mask_.empty()) return out;
  cv::Mat followed;
  cv::dilate(last_mask_, followed, square(2 * kPersonReach * background_.rows));
  return out | followed;
}

cv::Mat PersonMasker::foreground(const cv::Mat& picture, const cv::Mat& lit, const cv::Mat& difference) const {
  cv::Mat mask = difference > threshold_;
  if (options_.drop_soft_light) mask = without_soft_light(mask, picture, lit);
  if (options_.half_contrast_edge) mask = edge_at_half_contrast(without_halo(mask, difference), difference);
  return mask;
}

// Large parts at the picture's sides, as long as they may be somebody who comes in. A first look at half a body takes
// an arm for all of it.
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
  if (any && !entering_s_) entering_s_ = time_s;
  if (!entering_s_ || time_s - *entering_s_ <= kEntersWithin) return out;
  if (!any) entering_s_.reset();
  return cv::Mat::zeros(foreground.size(), CV_8UC1);
}

MaskResult PersonMasker::process(const cv::Mat& picture, const PersonEvidence& looked, double time_s) {
  assert(picture.type() == CV_8UC3 && picture.size() == background_.size());
  const double dt_s = last_time_s_ ? time_s - *last_time_s_ : 0.0;
  last_time_s_ = time_s;
  MaskResult result;
  result.mask = cv::Mat::zeros(picture.size(), CV_8UC1);

  constexpr double kMoment = 0.3;
  cv::subtract(lately_, std::ceil(255 * std::max(0.0, dt_s) / kMoment), lately_);
  PersonEvidence person = looked;
  cv::Mat near = expected(person, time_s);
  const cv::Mat about_them =
      person.about_others.empty() ? cv::Mat::zeros(picture.size(), CV_8UC1) : person.about_others;
  ToneCurve curve;
  if (options_.follow_exposure) curve = ToneCurve(background_, picture, near | about_them | (free_looks_ < kYoung));
  cv::Mat lit = curve.apply(background_);
  cv::Mat difference = difference_luminance(picture, lit);
  if (options_.sudden_percent < 100) {
    const cv::Mat beside = ~(near | about_them | never_seen_);
    const double changed = cv::countNonZero((difference > threshold_) & beside);
    if (changed > options_.sudden_percent / 100 * cv::countNonZero(beside) && changed > 0) {
      // Another scene: all that is known of it is what stands beside the person now.
      result.sudden = true;
      near = possible(person, picture.size());
      background_ = picture.clone();
      background_.convertTo(running_, CV_32F);
      never_seen_ = near | about_them;
      free_looks_.setTo(kYoung);
      free_looks_.setTo(0, never_seen_);
      last_mask_.release();
      lately_.setTo(0);
      lit = background_;
      difference = cv::Mat::zeros(picture.size(), CV_8UC1);
    }
  }
  cv::Mat mask = foreground(picture, lit, difference);
  if (is_the_room(person, mask)) {
    person = {};
    near = expected(person, time_s);
  }
  if (entering_s_ || cv::countNonZero(near) == 0) {
    cv::Mat comes = entering(annealed(mask & ~never_seen_, options_.steps), time_s);
    cv::dilate(comes, comes, square(kPersonReach * picture.rows));
    near |= comes;
  }
  if (cv::countNonZero(near) > 0) {
    mask &= near | (lately_ > 0);  // In single pictures the network takes an arm for the other one.
    if (!person.likely.empty()) last_seen_s_ = time_s;
    const bool sudden = result.sudden;
    mask = with_the_networks_word(mask, person);
    mask &= ~others_alone(person, mask.size());
    result = finished(mask);
    result.sudden = sudden;
    result.inferred = cv::countNonZero(result.mask & never_seen_);
  }
  last_mask_ = result.body ? result.mask : cv::Mat();
  // Who is not seen may stand there all the same, for a while: nothing comes to light but beside somebody who is seen.
  if (!first_time_s_) first_time_s_ = time_s;
  const bool known = !person.likely.empty() || time_s - last_seen_s_.value_or(*first_time_s_) > kFollowedFor;
  near = near | about_them | result.mask;
  if (!person.likely.empty()) lately_ |= possible(person, picture.size());
  learn(picture, lit, known ? cv::Mat(~near) : cv::Mat(~(near | never_seen_)), dt_s);
  return result;
}

MaskResult PersonMasker::finished(cv::Mat mask) const {
  MaskResult result;
  result.mask = cv::Mat::zeros(mask.size(), CV_8UC1);
  mask = annealed(mask, options_.steps);
  if (!allowed_.empty()) mask &= allowed_;
  const int speck = static_cast<int>(std::ceil(options_.speck_percent / 100.0 * double(mask.total())));
  mask = without_specks(mask, speck, options_.largest_only);
  const int area = cv::countNonZero(mask);
  if (area == 0 || area < options_.min_body_percent / 100.0 * double(mask.total())) return result;
  result.mask = mask;
  result.area = area;
  result.body = true;
  const auto box = cv::boundingRect(mask);
  result.cut = box.x == 0 || box.y == 0 || box.br().x == mask.cols || box.br().y == mask.rows;
  return result;
}

MaskResult PersonMasker::silhouette(const PersonEvidence& person) const {
  if (person.likely.empty()) return finished(cv::Mat::zeros(background_.size(), CV_8UC1));
  auto result = finished(person.likely > kLikely);
  result.inferred = result.area;
  return result;
}

void PersonMasker::forget(const cv::Mat& picture) {
  background_ = picture.clone();
  background_.convertTo(running_, CV_32F);
  never_seen_.setTo(255);
  free_looks_.setTo(0);
  last_mask_.release();
  lately_.setTo(0);
  entering_s_.reset();
}

// What is seen while it is free, in the light of the plate: quickly at first, so that a jacket that the silhouette
// lacked for a moment fades, and as the mean of the last follow_s later.
void PersonMasker::learn(const cv::Mat& picture, const cv::Mat& lit, const cv::Mat& surely_not, double dt_s) {
  const bool follows = options_.follow_s > 0 && dt_s > 0;
  const auto rate = follows ? static_cast<float>(1.0 - std::exp(-dt_s / options_.follow_s)) : 0.0F;
  tbb::parallel_for(tbb::blocked_range<int>(0, picture.rows), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y) {
      const auto* free = surely_not.ptr<std::uint8_t>(y);
      const auto* now = picture.ptr<std::uint8_t>(y);
      const auto* then = lit.ptr<std::uint8_t>(y);
      auto* looks = free_looks_.ptr<std::uint8_t>(y);
      auto* never = never_seen_.ptr<std::uint8_t>(y);
      auto* running = running_.ptr<float>(y);
      auto* background = background_.ptr<std::uint8_t>(y);
      for (int x = 0; x < picture.cols; ++x) {
        if (free[x] == 0) {
          if (never[x] != 0) looks[x] = 0;
          continue;
        }
        const bool young = looks[x] < kYoung;
        if (!young && rate == 0.0F) continue;
        if (young && ++looks[x] >= kKnown) never[x] = 0;
        const float weight = young ? std::max(rate, 1.0F / float(std::min(looks[x], kMean))) : rate;
        for (int c = 3 * x; c < 3 * x + 3; ++c) {
          running[c] += weight * (float(now[c]) - float(then[c]));
          background[c] = cv::saturate_cast<std::uint8_t>(running[c]);
        }
      }
    }
  });
}

}  // namespace choreo::vision
