// SPDX-License-Identifier: Apache-2.0
#include "vision/tone_curve.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>

namespace choreo::vision {
namespace {

constexpr int kLevels = 16;  // Grey levels a range.
constexpr int kRanges = 256 / kLevels;

constexpr int kPeakReach = 4;        // Grey levels: a peak's half width, for noise and texture.
constexpr double kLeastShare = 0.3;  // Of a range's pixels that must have done alike.

// How much the pixels of a range changed, and the sum of what they were.
struct Seen {
  std::array<std::uint32_t, 511> change{};  // By change + 255.
  std::uint64_t sum_before = 0;
  std::uint64_t count = 0;
};

struct Peak {
  double change = 0;
  std::uint64_t count = 0;  // Pixels that changed so.
};

// The commonest change within least to most: what a wall's pixels of one level do in another light, they do together,
// while what a body in front makes of them is scattered. A mean around the peak gives parts of a level.
Peak commonest_change(const Seen& seen, int least, int most) {
  const int first = std::max(0, least + 255);
  const int last = std::min(510, most + 255);
  Peak best;
  int at = first - 1;
  for (int i = first; i <= last; ++i) {
    std::uint64_t count = 0;
    for (int k = std::max(0, i - kPeakReach); k <= std::min(510, i + kPeakReach); ++k)
      count += seen.change[std::size_t(k)];
    if (count > best.count) {
      best.count = count;
      at = i;
    }
  }
  if (best.count == 0) return best;
  double weighted = 0;
  for (int k = std::max(0, at - kPeakReach); k <= std::min(510, at + kPeakReach); ++k) {
    weighted += double(seen.change[std::size_t(k)]) * (k - 255);
  }
  best.change = weighted / double(best.count);
  return best;
}

}  // namespace

ToneCurve::ToneCurve() {
  for (auto& channel : levels_) std::iota(channel.begin(), channel.end(), std::uint8_t{0});
}

ToneCurve::ToneCurve(const cv::Mat& from, const cv::Mat& to, const cv::Mat& except, int spread) : ToneCurve() {
  assert(from.type() == CV_8UC3 && to.type() == CV_8UC3 && from.size() == to.size());
  std::vector<std::array<Seen, kRanges>> seen(3);
  std::uint64_t total = 0;
  // Of a large picture a part tells as much.
  constexpr int kManyRows = 240;
  for (int y = 0; y < from.rows; y += from.rows < kManyRows ? 2 : 4) {
    const auto* f = from.ptr<std::uint8_t>(y);
    const auto* t = to.ptr<std::uint8_t>(y);
    const auto* skip = except.empty() ? nullptr : except.ptr<std::uint8_t>(y);
    for (int x = 0; x < from.cols; x += 2) {
      if (skip != nullptr && skip[x] != 0) continue;
      ++total;
      for (std::size_t c = 0; c < 3; ++c) {
        const auto before = f[3 * x + int(c)];
        auto& s = seen[c][before / kLevels];
        ++s.change[std::size_t(t[3 * x + int(c)] - before + 255)];
        s.sum_before += before;
        ++s.count;
      }
    }
  }
  bool changes = false;
  const auto enough = std::max<std::uint64_t>(8, total / 500);
  for (int channel = 0; channel < 3; ++channel) {
    const auto& ranges = seen[std::size_t(channel)];
    Seen all;
    for (const auto& s : ranges) {
      for (std::size_t i = 0; i < s.change.size(); ++i) all.change[i] += s.change[i];
    }
    const int common = static_cast<int>(std::lround(commonest_change(all, -255, 255).change));
    std::vector<std::pair<double, double>> knots;  // Level before, level after.
    for (const auto& s : ranges) {
      if (s.count < enough) continue;
      const auto peak = commonest_change(s, common - spread, common + spread);
      if (double(peak.count) < kLeastShare * double(s.count)) continue;
      const double before = double(s.sum_before) / double(s.count);
      const double least = knots.empty() ? 0.0 : knots.back().second;
      knots.emplace_back(before, std::max(least, before + peak.change));
    }
    if (knots.empty()) continue;
    for (int level = 0; level < 256; ++level) {
      // Beyond the outermost knots the curve keeps its distance.
      double after = level + knots.front().second - knots.front().first;
      if (level >= knots.back().first) {
        after = level + knots.back().second - knots.back().first;
      } else if (level > knots.front().first) {
        const auto right = std::find_if(knots.begin(), knots.end(), [&](const auto& k) { return k.first >= level; });
        const auto left = right - 1;
        after = left->second + (level - left->first) * (right->second - left->second) / (right->first - left->first);
      }
      auto& here = levels_[std::size_t(channel)][std::size_t(level)];
      here = cv::saturate_cast<std::uint8_t>(after);
      changes = changes || common != 0 || std::abs(here - level) > 1;
    }
  }
  if (!changes) *this = ToneCurve();
}

cv::Mat ToneCurve::apply(const cv::Mat& picture) const {
  assert(picture.type() == CV_8UC3);
  if (levels_ == ToneCurve().levels_) return picture.clone();
  // cv::LUT takes three times as long for tables of more than one channel.
  const auto& [blue, green, red] = levels_;
  cv::Mat out(picture.size(), CV_8UC3);
  for (int y = 0; y < picture.rows; ++y) {
    const auto* __restrict in = picture.ptr<std::uint8_t>(y);
    auto* __restrict o = out.ptr<std::uint8_t>(y);
    const int count = 3 * picture.cols;
    for (int x = 0; x < count; x += 3) {
      o[x] = blue[in[x]];
      o[x + 1] = green[in[x + 1]];
      o[x + 2] = red[in[x + 2]];
    }
  }
  return out;
}

}  // namespace choreo::vision
