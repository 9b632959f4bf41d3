// SPDX-License-Identifier: Apache-2.0
#include "vision/depth_background.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <opencv2/imgproc.hpp>

namespace choreo::vision {
namespace {

using Depth = std::uint16_t;

constexpr double kLeastGap_mm = 30.0;
constexpr double kGapPerMm = 6e-6;         // times z^2: two steps of a Kinect's disparity
constexpr double kLeastShare = 0.05;       // of the pictures: fewer readings tell nothing
constexpr double kUsualNoisePerMm = 1e-6;  // of a Kinect, where too few pictures tell
constexpr std::size_t kReadingsThatTell = 5;
constexpr double kSomeEmpty = 0.05;      // of the pictures: somebody left, or stood still
constexpr double kMostlyEmpty = 0.5;     // likewise: the room was seen
constexpr double kBodyShare = 0.005;     // of the pixels: a smaller body is none
constexpr double kWidestBody = 1.0 / 3;  // of the picture's width
constexpr double kNarrowGap = 1.0 / 40;  // likewise: what shows of the room in less tells nothing
constexpr double kStandsOut_mm = 150.0;  // what was never seen behind is nearer than the room beside it
constexpr double kOneBody_mm = 100.0;    // neighbours on one body differ by less
constexpr double kTouchingShare = 0.25;  // of the pictures,
constexpr double kAlwaysTouching = 0.9;  // or, where some show no body, of those that do
constexpr int kTouchingPixels = 2;

struct Mode {
  Depth median = 0;
  double deviation = 0;
  std::size_t readings = 0;
};

// The farthest run of enough readings; see the header.
Mode farthest_mode(std::vector<Depth>& readings, std::size_t enough) {
  if (readings.size() < enough) return {};
  std::sort(readings.begin(), readings.end());
  std::size_t begin = readings.size(), end = readings.size();  // of the run chosen
  std::size_t largest = 0;
  for (std::size_t last = readings.size(); last > 0;) {
    std::size_t first = last - 1;
    const double z = readings[first];
    const double gap = std::max(kLeastGap_mm, kGapPerMm * z * z);
    while (first > 0 && readings[first] - readings[first - 1] <= gap) --first;
    if (last - first > largest) {
      largest = last - first;
      begin = first;
      end = last;
    }
    if (last - first >= enough) break;
    last = first;
  }
  Mode mode;
  mode.readings = end - begin;
  mode.median = readings[begin + mode.readings / 2];
  double sum = 0, squares = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const double away = double(readings[i]) - double(mode.median);
    sum += away;
    squares += away * away;
  }
  const double n = double(mode.readings);
  mode.deviation = std::sqrt(std::max(0.0, squares / n - (sum / n) * (sum / n)));
  return mode;
}

double noise_per_mm(const cv::Mat1w& depth, const cv::Mat1f& spread, const cv::Mat1w& readings) {
  std::vector<double> all;
  for (int y = 0; y < depth.rows; ++y) {
    for (int x = 0; x < depth.cols; ++x) {
      if (readings(y, x) < kReadingsThatTell) continue;
      all.push_back(double(spread(y, x)) / (double(depth(y, x)) * double(depth(y, x))));
    }
  }
  if (all.empty()) return kUsualNoisePerMm;
  const auto middle = all.begin() + std::ptrdiff_t(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  return *middle;
}

const std::array<cv::Point, 4> kNeighbours = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

// Numbers the parts of `where` (from 1; 0 elsewhere) over which the depth goes on without a jump.
int label_surfaces(const cv::Mat1b& where, const cv::Mat1w& depth, cv::Mat1i& labels) {
  const cv::Rect all({0, 0}, where.size());
  labels = cv::Mat1i::zeros(where.size());
  int count = 0;
  std::vector<cv::Point> open;
  for (int y = 0; y < where.rows; ++y) {
    for (int x = 0; x < where.cols; ++x) {
      if (where(y, x) == 0 || labels(y, x) != 0) continue;
      labels(y, x) = ++count;
      open.assign(1, {x, y});
      while (!open.empty()) {
        const auto p = open.back();
        open.pop_back();
        for (const auto& step : kNeighbours) {
          const auto q = p + step;
          if (!all.contains(q) || where(q) == 0 || labels(q) != 0) continue;
          if (std::abs(int(depth(q)) - int(depth(p))) > kOneBody_mm) continue;
          labels(q) = count;
          open.push_back(q);
        }
      }
    }
  }
  return count;
}

// Adds 1 to each surface at which, in this picture, the moving body goes on.
void count_touching(const cv::Mat1i& labels, const cv::Mat1w& picture, const cv::Mat1b& moving,
                    std::vector<int>& touching) {
  const cv::Rect all({0, 0}, labels.size());
  std::vector<int> pixels(touching.size(), 0);
  for (int y = 0; y < labels.rows; ++y) {
    for (int x = 0; x < labels.cols; ++x) {
      const cv::Point p(x, y);
      if (labels(p) == 0 || picture(p) == 0 || moving(p) != 0) continue;
      const bool goes_on = std::any_of(kNeighbours.begin(), kNeighbours.end(), [&](const cv::Point& step) {
        const auto q = p + step;
        return all.contains(q) && moving(q) != 0 && picture(q) != 0 &&
               std::abs(int(picture(q)) - int(picture(p))) <= kOneBody_mm;
      });
      if (goes_on) ++pixels[std::size_t(labels(p))];
    }
  }
  for (std::size_t i = 1; i < touching.size(); ++i) touching[i] += pixels[i] >= kTouchingPixels ? 1 : 0;
}

// Takes the room beside it where a body stood in all the pictures.
void infer_behind_body(DepthBackground& room, std::span<const cv::Mat> pictures, const DepthMargin& margin) {
  const cv::Mat1w depth = room.depth_mm;
  const auto row = [&](double share) {
    const int width = 2 * static_cast<int>(std::lround(share * depth.cols / 2)) + 1;
    return cv::getStructuringElement(cv::MORPH_RECT, {width, 1});
  };
  // Of each row first what is farther than both its sides over a narrow gap goes, an error or next to nothing; then
  // what is nearer than both its sides, over at most a body's width, is filled.
  cv::Mat1w beside;
  cv::morphologyEx(depth, beside, cv::MORPH_OPEN, row(kNarrowGap));
  cv::morphologyEx(beside, beside, cv::MORPH_CLOSE, row(kWidestBody));
  cv::Mat1b stands_out(depth.size());
  for (int y = 0; y < depth.rows; ++y) {
    for (int x = 0; x < depth.cols; ++x) {
      stands_out(y, x) = depth(y, x) != 0 && beside(y, x) > depth(y, x) + kStandsOut_mm ? 255 : 0;
    }
  }
  cv::Mat1i labels;
  const int count = label_surfaces(stands_out, depth, labels);
  if (count == 0) return;
  std::vector<int> touching(std::size_t(count) + 1, 0);
  for (const auto& picture : pictures) count_touching(labels, picture, nearer_than(room, picture, margin), touching);
  const double all = double(pictures.size());
  const double enough = room.empty < kSomeEmpty ? kTouchingShare * all : kAlwaysTouching * (1 - room.empty) * all;
  cv::Mat1b inferred = cv::Mat1b::zeros(depth.size());
  cv::Mat1w behind = depth.clone();
  for (int y = 0; y < depth.rows; ++y) {
    for (int x = 0; x < depth.cols; ++x) {
      if (labels(y, x) == 0 || touching[std::size_t(labels(y, x))] < enough) continue;
      inferred(y, x) = 255;
      behind(y, x) = beside(y, x);
    }
  }
  if (cv::countNonZero(inferred) == 0) return;
  room.depth_mm = behind;
  room.inferred = inferred;
}

}  // namespace

double DepthBackground::known_share() const { return double(cv::countNonZero(depth_mm)) / double(depth_mm.total()); }

double DepthBackground::inferred_share() const {
  return inferred.empty() ? 0.0 : double(cv::countNonZero(inferred)) / double(inferred.total());
}

DepthBackground learn_depth_background(std::span<const cv::Mat> pictures, const DepthMargin& margin) {
  assert(!pictures.empty() && pictures.front().type() == CV_16UC1);
  const auto size = pictures.front().size();
  const auto enough = std::size_t(std::ceil(kLeastShare * double(pictures.size())));
  cv::Mat1w depth(size), readings(size);
  cv::Mat1f spread(size);
  tbb::parallel_for(tbb::blocked_range<int>(0, size.height), [&](const tbb::blocked_range<int>& rows) {
    std::vector<Depth> values;
    for (int y = rows.begin(); y < rows.end(); ++y) {
      for (int x = 0; x < size.width; ++x) {
        values.clear();
        for (const auto& picture : pictures) {
          const auto z = picture.ptr<Depth>(y)[x];
          if (z != 0) values.push_back(z);
        }
        const auto mode = farthest_mode(values, enough);
        depth(y, x) = mode.median;
        spread(y, x) = static_cast<float>(mode.deviation);
        readings(y, x) = static_cast<Depth>(std::min<std::size_t>(mode.readings, 65535));
      }
    }
  });
  DepthBackground room;
  room.depth_mm = depth;
  room.noise_per_mm = noise_per_mm(depth, spread, readings);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double z = depth(y, x);
      spread(y, x) = std::max(spread(y, x), static_cast<float>(room.noise_per_mm * z * z));
    }
  }
  room.spread_mm = spread;
  int empty = 0;
  for (const auto& picture : pictures) {
    cv::Mat body = nearer_than(room, picture, margin);
    cv::medianBlur(body, body, 3);
    empty += cv::countNonZero(body) < kBodyShare * double(body.total()) ? 1 : 0;
  }
  room.empty = double(empty) / double(pictures.size());
  if (room.empty < kMostlyEmpty) infer_behind_body(room, pictures, margin);
  return room;
}

cv::Mat nearer_than(const DepthBackground& room, const cv::Mat& depth_mm, const DepthMargin& margin) {
  assert(depth_mm.type() == CV_16UC1 && depth_mm.size() == room.depth_mm.size());
  cv::Mat out(depth_mm.size(), CV_8UC1);
  for (int y = 0; y < depth_mm.rows; ++y) {
    const auto* now = depth_mm.ptr<Depth>(y);
    const auto* behind = room.depth_mm.ptr<Depth>(y);
    const auto* spread = room.spread_mm.ptr<float>(y);
    auto* body = out.ptr<std::uint8_t>(y);
    for (int x = 0; x < depth_mm.cols; ++x) {
      const bool nearer = now[x] != 0 && behind[x] != 0 && float(now[x]) + margin.of(spread[x]) < float(behind[x]);
      body[x] = nearer ? 255 : 0;
    }
  }
  return out;
}

}  // namespace choreo::vision
