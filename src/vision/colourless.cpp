// SPDX-License-Identifier: Apache-2.0
#include "vision/colourless.hpp"

#include <algorithm>
#include <cstdint>

namespace choreo::vision {

bool colourless(const cv::Mat& picture) {
  constexpr int kApart = 8;
  constexpr std::int64_t kOneIn = 1000;
  std::int64_t coloured = 0;
  for (int y = 0; y < picture.rows; ++y) {
    const auto* row = picture.ptr<cv::Vec3b>(y);
    for (int x = 0; x < picture.cols; ++x) {
      const auto [least, most] = std::minmax({row[x][0], row[x][1], row[x][2]});
      coloured += int(most) - int(least) > kApart ? 1 : 0;
    }
  }
  return coloured * kOneIn < std::int64_t(picture.total()) || picture.empty();
}

}  // namespace choreo::vision
