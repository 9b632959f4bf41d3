// SPDX-License-Identifier: Apache-2.0
#include "vision/depth_masker.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <utility>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "core/error.hpp"
#include "vision/difference.hpp"

namespace choreo::vision {
namespace {

using Depth = std::uint16_t;

constexpr double kHoleShare = 0.001;        // of the picture: a smaller hole is a fault of the sensor
constexpr int kGoesOn_mm = 100;             // neighbours on one body differ by less
constexpr std::uint8_t kLeastReadings = 3;  // in a row: one may be an error,
constexpr double kLasts_s = 0.15;           // and over so long, whatever the frame rate
constexpr double kMissing_s = 0.25;         // without a reading for longer, what was seen before counts no more
constexpr double kRemembered_s = 60;        // the nearer depth of what went away
constexpr double kOneSurface = 0.95;        // of a surface that came back: a body sticks out of where the leaf was,
constexpr double kStillOpen = 0.1;          // or more than this of what is behind shows beside it

void check(double value, double least, double most, const char* option, const char* range, bool open_below = false) {
  if ((open_below ? value > least : value >= least) && value <= most) return;
  throw usage_error(fmt::format("{} is {}", option, value), {}, fmt::format("{} is {}", option, range));
}

// `certain`, and of `likely` what goes on from it without a jump in depth.
cv::Mat going_on(const cv::Mat1b& certain, const cv::Mat1b& likely, const cv::Mat1w& depth) {
  cv::Mat1b out = certain.clone();
  if (cv::countNonZero(likely) == 0) return out;
  const cv::Rect all({0, 0}, depth.size());
  std::vector<cv::Point> open;
  cv::findNonZero(certain, open);
  while (!open.empty()) {
    const auto p = open.back();
    open.pop_back();
    for (const auto& step : {cv::Point(1, 0), cv::Point(-1, 0), cv::Point(0, 1), cv::Point(0, -1)}) {
      const auto q = p + step;
      if (!all.contains(q) || out(q) != 0 || likely(q) == 0) continue;
      if (std::abs(int(depth(q)) - int(depth(p))) > kGoesOn_mm) continue;
      out(q) = 255;
      open.push_back(q);
    }
  }
  return out;
}

}  // namespace

void DepthMasker::Lasting::begin(cv::Size size) {
  readings_ = cv::Mat::zeros(size, CV_8UC1);
  since_s_ = cv::Mat::zeros(size, CV_64FC1);
  last_s_ = cv::Mat::zeros(size, CV_64FC1);
}

bool DepthMasker::Lasting::saw(cv::Point p, double time_s, double longest_gap_s) {
  auto& readings = readings_.at<std::uint8_t>(p);
  auto& since_s = since_s_.at<double>(p);
  auto& last_s = last_s_.at<double>(p);
  if (readings == 0 || time_s - last_s > longest_gap_s) {
    readings = 0;
    since_s = time_s;
  }
  last_s = time_s;
  if (readings < kLeastReadings) ++readings;
  return readings == kLeastReadings && time_s - since_s >= kLasts_s;
}

void DepthMasker::Lasting::forget(cv::Point p) { readings_.at<std::uint8_t>(p) = 0; }

void DepthOptions::validate() const {
  if (threshold_mm)
    check(*threshold_mm, 0, 5000, "depth.threshold_mm", "above 0 and at most 5000 mm, or \"auto\"", true);
  check(spread_factor, 1, 20, "depth.spread_factor", "from 1 to 20");
  check(least_threshold_mm, 1, 1000, "depth.least_threshold_mm", "from 1 to 1000 mm");
  check(near_mm, 0, 20000, "depth.near_mm", "from 0 to 20000 mm");
  check(far_mm, 0, 20000, "depth.far_mm", "from 0 (no such plane) to 20000 mm");
  if (far_mm > 0 && far_mm <= near_mm) {
    throw usage_error(fmt::format("depth.far_mm is {} and depth.near_mm is {}", far_mm, near_mm), {},
                      "the far plane lies behind the near one");
  }
}

DepthMargin DepthOptions::margin() const {
  return threshold_mm ? DepthMargin{0, *threshold_mm} : DepthMargin{spread_factor, least_threshold_mm};
}

DepthMasker::DepthMasker(DepthBackground room, DepthOptions options, MaskOptions mask)
    : options_(options), mask_options_(std::move(mask)), margin_(options.margin()) {
  options_.validate();
  mask_options_.validate();
  allowed_ = allowed_area(mask_options_, room.depth_mm.size());
  begin(std::move(room));
}

void DepthMasker::begin(DepthBackground room) {
  room_ = std::move(room);
  // They are written to, and whoever learned them may look at them again.
  room_.depth_mm = room_.depth_mm.clone();
  room_.spread_mm = room_.spread_mm.clone();
  room_.inferred = room_.inferred.clone();
  room_.depth_mm.convertTo(running_mm_, CV_32F);
  const auto size = room_.depth_mm.size();
  beyond_.begin(size);
  back_.begin(size);
  old_mm_ = cv::Mat::zeros(size, CV_32FC1);
  old_spread_mm_ = cv::Mat::zeros(size, CV_32FC1);
  old_until_s_ = cv::Mat::zeros(size, CV_64FC1);
  remembered_until_s_.reset();
}

cv::Mat DepthMasker::standing_before(const cv::Mat& depth_mm) const {
  cv::Mat certain = nearer_than(room_, depth_mm, margin_);
  cv::Mat before_unknown = (room_.depth_mm == 0) & (depth_mm != 0);
  const bool far_plane = options_.far_mm > 0;
  if (options_.near_mm > 0 || far_plane) {
    const cv::Mat between = (depth_mm >= options_.near_mm) & (depth_mm <= (far_plane ? options_.far_mm : 65535.0));
    certain &= between;
    before_unknown &= between;
  }
  return far_plane ? cv::Mat(certain | before_unknown) : going_on(certain, before_unknown, depth_mm);
}

double DepthMasker::moved_percent(const cv::Mat& depth_mm) const {
  std::size_t moved = 0;
  for (int y = 0; y < depth_mm.rows; ++y) {
    const auto* now = depth_mm.ptr<Depth>(y);
    const auto* behind = room_.depth_mm.ptr<Depth>(y);
    const auto* spread = room_.spread_mm.ptr<float>(y);
    for (int x = 0; x < depth_mm.cols; ++x) {
      if (now[x] == 0 || behind[x] == 0) continue;
      moved += std::abs(float(now[x]) - float(behind[x])) > margin_.of(spread[x]) ? 1 : 0;
    }
  }
  return 100.0 * double(moved) / double(depth_mm.total());
}

DepthMask DepthMasker::process(const cv::Mat& depth_mm, double time_s) {
  assert(depth_mm.type() == CV_16UC1 && depth_mm.size() == room_.depth_mm.size());
  const double dt_s = last_time_s_ ? time_s - *last_time_s_ : 0.0;
  last_time_s_ = time_s;
  DepthMask result;
  result.body = cv::Mat::zeros(depth_mm.size(), CV_8UC1);
  result.known = result.body.clone();
  if (!learning_since_s_ && mask_options_.sudden_percent < 100 &&
      moved_percent(depth_mm) > mask_options_.sudden_percent) {
    result.sudden = true;
    learning_since_s_ = time_s;
  }
  if (learning_since_s_) {
    result.learning = relearn(depth_mm, time_s);
    if (result.learning) return result;
  }
  cv::Mat body = standing_before(depth_mm);
  cv::medianBlur(body, body, 3);
  body = annealed(body, mask_options_.steps);
  body = without_small_holes(body, static_cast<int>(kHoleShare * double(body.total())));
  if (!allowed_.empty()) body &= allowed_;
  result.body = body;
  result.known = body | (depth_mm != 0);
  follow(depth_mm, body, time_s, dt_s);
  take_back(depth_mm, body, time_s, dt_s);
  result.inferred = room_.inferred;
  return result;
}

void DepthMasker::follow(const cv::Mat& depth_mm, const cv::Mat& body, double time_s, double dt_s) {
  const auto rate = mask_options_.follow_s > 0 && dt_s > 0
                        ? static_cast<float>(1.0 - std::exp(-dt_s / mask_options_.follow_s))
                        : 0.0F;
  const double longest_gap_s = std::max(kMissing_s, dt_s);
  // Beside a body its edge wanders: no place to learn what was never known.
  cv::Mat near;
  cv::dilate(body, near, cv::getStructuringElement(cv::MORPH_RECT, {5, 5}));
  for (int y = 0; y < depth_mm.rows; ++y) {
    const auto* now = depth_mm.ptr<Depth>(y);
    const auto* is_body = body.ptr<std::uint8_t>(y);
    const auto* is_near = near.ptr<std::uint8_t>(y);
    auto* behind = room_.depth_mm.ptr<Depth>(y);
    auto* spread = room_.spread_mm.ptr<float>(y);
    auto* running = running_mm_.ptr<float>(y);
    auto* inferred = room_.inferred.empty() ? nullptr : room_.inferred.ptr<std::uint8_t>(y);
    for (int x = 0; x < depth_mm.cols; ++x) {
      // Of an unknown room every reading is beyond what is known, where there is no body.
      if (now[x] == 0 || (behind[x] == 0 && is_near[x] != 0)) continue;
      const float away = float(now[x]) - running[x];
      const float margin = margin_.of(spread[x]);
      if (away > margin) {
        if (!beyond_.saw({x, y}, time_s, longest_gap_s)) continue;
        // What is only inferred was never seen, and will not come back.
        if (behind[x] != 0 && (inferred == nullptr || inferred[x] == 0)) remember({x, y}, time_s);
        running[x] = float(now[x]);
        spread[x] = static_cast<float>(room_.noise_per_mm * double(now[x]) * double(now[x]));
        if (inferred != nullptr) inferred[x] = 0;
      } else if (is_body[x] == 0 && away >= -margin) {
        running[x] += rate * away;
      }
      beyond_.forget({x, y});
      behind[x] = static_cast<Depth>(running[x] + 0.5F);
    }
  }
}

void DepthMasker::remember(cv::Point p, double time_s) {
  auto& old_mm = old_mm_.at<float>(p);
  auto& until_s = old_until_s_.at<double>(p);
  // Of a leaf that swings away step by step, where it was at first.
  if (old_mm == 0 || time_s > until_s) {
    old_mm = running_mm_.at<float>(p);
    old_spread_mm_.at<float>(p) = room_.spread_mm.at<float>(p);
  }
  until_s = time_s + kRemembered_s;
  remembered_until_s_ = until_s;
}

void DepthMasker::take_back(const cv::Mat& depth_mm, const cv::Mat& body, double time_s, double dt_s) {
  if (!remembered_until_s_ || time_s > *remembered_until_s_) return;
  const auto size = depth_mm.size();
  const cv::Mat1w now = depth_mm;
  const cv::Mat1f old_mm = old_mm_, old_spread_mm = old_spread_mm_;
  const cv::Mat1d until_s = old_until_s_;
  cv::Mat1b remembered = cv::Mat1b::zeros(size), returned = cv::Mat1b::zeros(size), open = cv::Mat1b::zeros(size);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      if (old_mm(y, x) == 0 || time_s > until_s(y, x)) continue;
      remembered(y, x) = 255;
      if (now(y, x) == 0) continue;
      const float away = float(now(y, x)) - old_mm(y, x);
      const float margin = margin_.of(old_spread_mm(y, x));
      open(y, x) = away > margin ? 255 : 0;
      returned(y, x) = std::abs(away) <= margin ? 255 : 0;
    }
  }
  returned &= body;
  if (cv::countNonZero(returned) == 0) return;

  // Surfaces of the body with what came back in them, and how much of each did.
  cv::Mat1i surface, region;
  const auto surfaces =
      std::size_t(cv::connectedComponents(going_on(returned, body & (depth_mm != 0), depth_mm), surface, 4, CV_32S));
  std::vector<int> pixels(surfaces, 0), came_back(surfaces, 0);
  // What is remembered, and of each connected part of it how much is covered again and how much is still open.
  const auto regions = std::size_t(cv::connectedComponents(remembered, region, 8, CV_32S));
  std::vector<int> covered(regions, 0), still_open(regions, 0);
  const auto each_pixel = [&](auto look) {
    for (cv::Point p; p.y < size.height; ++p.y) {
      for (p.x = 0; p.x < size.width; ++p.x) look(p, std::size_t(surface(p)), std::size_t(region(p)));
    }
  };
  each_pixel([&](cv::Point p, std::size_t s, std::size_t) {
    ++pixels[s];
    came_back[s] += returned(p) != 0 ? 1 : 0;
  });
  each_pixel([&](cv::Point p, std::size_t s, std::size_t r) {
    still_open[r] += open(p) != 0 ? 1 : 0;
    covered[r] += returned(p) != 0 && came_back[s] >= kOneSurface * pixels[s] ? 1 : 0;
  });
  each_pixel([&](cv::Point p, std::size_t, std::size_t r) {
    if (r == 0 || covered[r] == 0 || still_open[r] > kStillOpen * (covered[r] + still_open[r])) return;
    // Where a body hides it too.
    if (open(p) != 0 || !back_.saw(p, time_s, dt_s)) return;
    running_mm_.at<float>(p) = old_mm_.at<float>(p);
    room_.spread_mm.at<float>(p) = old_spread_mm_.at<float>(p);
    room_.depth_mm.at<Depth>(p) = static_cast<Depth>(running_mm_.at<float>(p) + 0.5F);
    old_mm_.at<float>(p) = 0;
    back_.forget(p);
    beyond_.forget(p);
  });
}

bool DepthMasker::relearn(const cv::Mat& depth_mm, double time_s) {
  constexpr std::size_t kMostPictures = 64;  // Bounds the memory.
  if (learning_.size() < kMostPictures) learning_.push_back(depth_mm.clone());
  if (time_s - *learning_since_s_ < mask_options_.relearn_s) return true;
  begin(learn_depth_background(learning_, margin_));
  learning_.clear();
  learning_since_s_.reset();
  return false;
}

}  // namespace choreo::vision
