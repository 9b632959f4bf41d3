// SPDX-License-Identifier: Apache-2.0
#include "vision/soft_light.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <vector>

#include <tbb/parallel_invoke.h>
#include <opencv2/imgproc.hpp>

#include "vision/runs.hpp"

namespace choreo::vision {
namespace {

constexpr float kDarkest = 0.3F;  // Of the ratio: less light is left only by a hard shadow.
constexpr float kBrightest = 1.4F;
constexpr float kStep = 0.20F;  // How much the ratio may change across a window of kWindow pixels.
constexpr int kWindow = 5;
constexpr float kOutline = 0.115F;    // How much it changes in the mean along the outline of clothes.
constexpr double kPartShare = 0.003;  // Of the picture: a smaller part's outline is too short to be judged by its mean.
constexpr int kTexture = 5;           // Pixels: the texture of a floor and the sensor's noise must not look like steps.
constexpr int kPixels = kTexture * kTexture;
constexpr int kOne = 128;          // A ratio in bytes, up to 2.
constexpr float kColour = 0.10F;   // How much a channel's ratio may be off.
constexpr float kRounding = 4.0F;  // And in grey levels: rounding and compression.

// The sums about each pixel of `box`, by channel, CV_16UC1: cv::blur takes seven times as long.
std::array<cv::Mat, 3> summed(const cv::Mat& picture, const cv::Rect& box) {
  static_assert(kTexture == 5);
  constexpr int kReach = kTexture / 2;
  cv::Mat about;  // With the pixels beside it, or their mirror images.
  const auto known = cv::Rect(box.x - kReach, box.y - kReach, box.width + 2 * kReach, box.height + 2 * kReach) &
                     cv::Rect({0, 0}, picture.size());
  cv::copyMakeBorder(picture(known), about, known.y - box.y + kReach, box.br().y + kReach - known.br().y,
                     known.x - box.x + kReach, box.br().x + kReach - known.br().x,
                     cv::BORDER_REFLECT_101 | cv::BORDER_ISOLATED);
  std::array<cv::Mat, 3> channels, out;
  cv::split(about, channels.data());
  std::vector<std::uint16_t> columns(std::size_t(about.cols));
  for (std::size_t c = 0; c < out.size(); ++c) {
    std::ranges::fill(columns, std::uint16_t{0});
    auto* __restrict sum = columns.data();
    const auto add = [&](int y, int sign) {
      const auto* line = channels[c].ptr<std::uint8_t>(y);
      const int count = about.cols;
      for (int x = 0; x < count; ++x) sum[x] = static_cast<std::uint16_t>(sum[x] + sign * line[x]);
    };
    for (int y = 0; y + 1 < kTexture; ++y) add(y, 1);
    out[c].create(box.size(), CV_16UC1);
    for (int y = 0; y < box.height; ++y) {
      add(y + kTexture - 1, 1);
      auto* o = out[c].ptr<std::uint16_t>(y);
      const int count = box.width;
      for (int x = 0; x < count; ++x)
        o[x] = static_cast<std::uint16_t>(sum[x] + sum[x + 1] + sum[x + 2] + sum[x + 3] + sum[x + 4]);
      add(y, -1);
    }
  }
  return out;
}

// Of `count` pixels, of which these are the sums now and before: the ratio of light, and whether one ratio serves all
// channels, 0 or 255.
void compare(const std::array<const std::uint16_t*, 3>& now, const std::array<const std::uint16_t*, 3>& before,
             std::uint8_t* __restrict ratio, std::uint8_t* __restrict of_light, int count) {
  const auto* __restrict b0 = before[0];
  const auto* __restrict g0 = before[1];
  const auto* __restrict r0 = before[2];
  const auto* __restrict b1 = now[0];
  const auto* __restrict g1 = now[1];
  const auto* __restrict r1 = now[2];
  constexpr float kRounded = kRounding * kPixels;
  for (int x = 0; x < count; ++x) {
    const auto bn = float(b1[x]), gn = float(g1[x]), rn = float(r1[x]);
    const auto bo = float(b0[x]), go = float(g0[x]), ro = float(r0[x]);
    // Some levels of both: without them the ratio of two dark pixels is noise.
    const float q =
        (0.114F * bn + 0.587F * gn + 0.299F * rn + kRounded) / (0.114F * bo + 0.587F * go + 0.299F * ro + kRounded);
    const float in_bytes = q * kOne + 0.5F;
    ratio[x] = static_cast<std::uint8_t>(static_cast<int>(in_bytes < 255.0F ? in_bytes : 255.0F));
    // Without branches: on clothes they go either way.
    const int same = int(q >= kDarkest) & int(q <= kBrightest) & int(std::abs(bn - q * bo) <= kRounded + kColour * bo) &
                     int(std::abs(gn - q * go) <= kRounded + kColour * go) &
                     int(std::abs(rn - q * ro) <= kRounded + kColour * ro);
    of_light[x] = static_cast<std::uint8_t>(-same);
  }
}

// The pixels of `soft` within `mask` that can be reached from outside it.
cv::Mat reached_from_outside(const cv::Mat& mask, const cv::Mat& soft) {
  cv::Mat inner;
  cv::erode(mask, inner, cv::getStructuringElement(cv::MORPH_CROSS, {3, 3}), {-1, -1}, 1,
            cv::BORDER_CONSTANT | cv::BORDER_ISOLATED);
  cv::Mat open = mask & soft;  // What may still be taken.
  const cv::Mat outermost = open & ~inner;
  cv::Mat reached = cv::Mat::zeros(mask.size(), CV_8UC1);
  std::vector<cv::Point> front;
  const auto take = [&](int x, int y) {
    if (x < 0 || y < 0 || x >= mask.cols || y >= mask.rows) return;
    auto& pixel = open.ptr<std::uint8_t>(y)[x];
    if (pixel == 0) return;
    pixel = 0;
    reached.ptr<std::uint8_t>(y)[x] = 255;
    front.emplace_back(x, y);
  };
  for (int y = 0; y < mask.rows; ++y) {
    for_each_run(outermost.ptr<std::uint8_t>(y), mask.cols, [&](int from, int to) {
      for (int x = from; x < to; ++x) take(x, y);
    });
  }
  while (!front.empty()) {
    const auto p = front.back();
    front.pop_back();
    take(p.x - 1, p.y);
    take(p.x + 1, p.y);
    take(p.x, p.y - 1);
    take(p.x, p.y + 1);
  }
  return reached;
}

// The parts' runs, of those parts for which `keep` is true.
template <typename Keep>
cv::Mat painted(const Parts& parts, cv::Size size, Keep keep) {
  cv::Mat out = cv::Mat::zeros(size, CV_8UC1);
  for (std::size_t k = 0; k < parts.runs.size(); ++k) {
    const auto& run = parts.runs[k];
    auto* line = out.ptr<std::uint8_t>(run.y);
    if (keep(parts.part_of[k])) std::fill(line + run.from, line + run.to, std::uint8_t{255});
  }
  return out;
}

// `taken` without its components that border more than `most` times as much on what is left of the mask as on the wall:
// clothes of the wall's colour, entered through a gap in their outline.
cv::Mat without_enclosed(const cv::Mat& taken, const cv::Mat& mask, int most) {
  const auto parts = parts_of(taken, Neighbours::kFour);
  std::vector<int> to_mask(parts.count, 0);
  std::vector<int> to_wall(parts.count, 0);
  for (std::size_t k = 0; k < parts.runs.size(); ++k) {
    const auto& run = parts.runs[k];
    const auto part = parts.part_of[k];
    const auto count = [&](int from, int to, int y) {
      if (y < 0 || y >= taken.rows) return;
      const auto* t = taken.ptr<std::uint8_t>(y);
      const auto* m = mask.ptr<std::uint8_t>(y);
      int beside = 0;
      int in_mask = 0;
      for (int x = std::max(from, 0); x < std::min(to, taken.cols); ++x) {
        beside += int(t[x] == 0);
        in_mask += int(t[x] == 0) & int(m[x] != 0);
      }
      to_mask[part] += in_mask;
      to_wall[part] += beside - in_mask;
    };
    count(run.from - 1, run.from, run.y);
    count(run.to, run.to + 1, run.y);
    count(run.from, run.to, run.y - 1);
    count(run.from, run.to, run.y + 1);
  }
  return painted(parts, taken.size(), [&](std::size_t part) { return most * to_wall[part] >= to_mask[part]; });
}

// `taken` without its components of more than `least_area` pixels whose border to the wall is, in the mean, as steep as
// an outline: clothes of the wall's hue, entered where the light on them meets the wall's. A shadow fades out.
cv::Mat without_outlined(const cv::Mat& taken, const cv::Mat& mask, const cv::Mat& steepness, int least_area) {
  struct Part {
    int area = 0;
    int border = 0;
    double steepness = 0;
  };
  const auto parts = parts_of(taken, Neighbours::kFour);
  std::vector<Part> seen(parts.count);
  const auto is_wall = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < mask.cols && y < mask.rows && mask.ptr<std::uint8_t>(y)[x] == 0;
  };
  for (std::size_t k = 0; k < parts.runs.size(); ++k) {
    const auto& run = parts.runs[k];
    auto& part = seen[parts.part_of[k]];
    part.area += run.to - run.from;
    for (int x = run.from; x < run.to; ++x) {
      if (!is_wall(x - 1, run.y) && !is_wall(x + 1, run.y) && !is_wall(x, run.y - 1) && !is_wall(x, run.y + 1))
        continue;
      ++part.border;
      part.steepness += double(steepness.ptr<std::uint8_t>(run.y)[x]) / kOne;
    }
  }
  return painted(parts, taken.size(), [&](std::size_t k) {
    const auto& part = seen[k];
    return !(part.area > least_area && part.steepness > double{kOutline} * part.border);
  });
}

}  // namespace

cv::Mat without_soft_light(const cv::Mat& mask, const cv::Mat& picture, const cv::Mat& background) {
  assert(mask.type() == CV_8UC1 && picture.type() == CV_8UC3 && background.type() == CV_8UC3);
  assert(mask.size() == picture.size() && mask.size() == background.size());
  const auto points = cv::boundingRect(mask);
  if (points.empty()) return mask.clone();
  // Only around the mask, with room for the windows.
  constexpr int kMargin = kWindow + 2;
  const auto box =
      cv::Rect(points.x - kMargin, points.y - kMargin, points.width + 2 * kMargin, points.height + 2 * kMargin) &
      cv::Rect({0, 0}, mask.size());
  std::array<cv::Mat, 3> now, before;
  tbb::parallel_invoke([&] { now = summed(picture, box); }, [&] { before = summed(background, box); });

  const cv::Mat window = cv::getStructuringElement(cv::MORPH_RECT, {kWindow, kWindow});
  cv::Mat looked_at;  // By a window around a pixel of the mask; elsewhere nobody asks what the light does.
  cv::dilate(mask(box), looked_at, window, {-1, -1}, 1, cv::BORDER_CONSTANT | cv::BORDER_ISOLATED);
  cv::Mat ratio(box.size(), CV_8UC1, cv::Scalar(kOne));
  cv::Mat of_light = cv::Mat::zeros(box.size(), CV_8UC1);  // Where one ratio serves all channels.
  for (int y = 0; y < box.height; ++y) {
    const auto at = [y](const std::array<cv::Mat, 3>& sums, int x) {
      return std::array{sums[0].ptr<std::uint16_t>(y) + x, sums[1].ptr<std::uint16_t>(y) + x,
                        sums[2].ptr<std::uint16_t>(y) + x};
    };
    for_each_run(looked_at.ptr<std::uint8_t>(y), box.width, [&](int from, int to) {
      compare(at(now, from), at(before, from), ratio.ptr<std::uint8_t>(y) + from, of_light.ptr<std::uint8_t>(y) + from,
              to - from);
    });
  }
  cv::Mat highest;
  cv::Mat lowest;
  tbb::parallel_invoke([&] { cv::dilate(ratio, highest, window); }, [&] { cv::erode(ratio, lowest, window); });
  const cv::Mat steepness = highest - lowest;
  const cv::Mat soft = of_light & (steepness <= kStep * kOne);

  cv::Mat out = mask.clone();
  cv::Mat inside = out(box);
  cv::Mat taken = reached_from_outside(inside, soft);
  // A step nearly all around is an outline, though it has a gap at a rounded corner, say: asked before the slivers go,
  // for it is as thin as they are.
  taken = without_enclosed(taken, inside & ~taken, 4);
  if (cv::countNonZero(taken) == 0) return out;
  // The texture of a floor leaves slivers behind, neither soft nor body: what is thin, of one ratio and beside what was
  // taken goes too.
  cv::Mat thick;
  cv::morphologyEx(inside & ~taken, thick, cv::MORPH_OPEN, window);
  cv::Mat near;
  cv::dilate(taken, near, window);
  taken |= inside & near & of_light & ~thick;
  taken = without_enclosed(taken, inside & ~taken, 1);
  inside.setTo(0, without_outlined(taken, inside, steepness, static_cast<int>(kPartShare * double(mask.total()))));
  return out;
}

}  // namespace choreo::vision
