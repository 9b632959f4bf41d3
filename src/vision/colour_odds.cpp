// SPDX-License-Identifier: Apache-2.0
#include "vision/colour_odds.hpp"

#include <cmath>
#include <cstddef>

namespace choreo::vision {
namespace {

constexpr float kOutliers = 0.4F;  // Share of the uniform density in either.

}  // namespace

ColourOdds::ColourOdds()
    : body_(std::size_t(kBins) * kBins * kBins, 0.0F), wall_(body_.size(), 0.0F), odds_(body_.size(), 0.0F) {}

void ColourOdds::finish() {
  const auto density = [](std::vector<float>& histogram) {
    // 1 2 1 along each axis.
    std::vector<float> line(kBins);
    for (const std::size_t stride : {std::size_t(1), std::size_t(kBins), std::size_t(kBins) * kBins}) {
      for (std::size_t begin = 0; begin < histogram.size(); ++begin) {
        if (begin / stride % kBins != 0) continue;
        for (std::size_t i = 0; i < kBins; ++i) line[i] = histogram[begin + i * stride];
        for (std::size_t i = 0; i < kBins; ++i) {
          const float below = line[i == 0 ? 0 : i - 1];
          const float above = line[i + 1 == kBins ? i : i + 1];
          histogram[begin + i * stride] = 0.25F * (below + above) + 0.5F * line[i];
        }
      }
    }
    double sum = 0;
    for (const float h : histogram) sum += h;
    const auto size = static_cast<float>(histogram.size());
    const float scale = sum > 0 ? static_cast<float>(1.0 / sum) * size : 0.0F;
    for (auto& h : histogram) h = (1.0F - kOutliers) * h * scale + kOutliers;
  };
  density(body_);
  density(wall_);
  for (std::size_t i = 0; i < odds_.size(); ++i) odds_[i] = std::log(body_[i] / wall_[i]);
}

}  // namespace choreo::vision
