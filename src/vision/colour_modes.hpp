// SPDX-License-Identifier: Apache-2.0
// The few colours that each pixel shows over time.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace choreo::vision {

/// Per pixel up to `kMost` clusters of colour, and which of them each picture shows there.
struct ColourModes {
  static constexpr int kMost = 5;
  static constexpr std::uint8_t kNone = 255;

  struct Mode {
    cv::Vec3b colour;  ///< Mean.
    int count = 0;     ///< Pictures that show it; 0: not used.
  };

  cv::Size size;
  int pictures = 0;
  std::vector<Mode> modes;  ///< kMost a pixel, by row and column, the commonest first.
  std::vector<cv::Mat> of;  ///< A picture each: CV_8UC1, the mode's place, or kNone where the colour fits none.

  [[nodiscard]] const Mode* at(int pixel) const { return modes.data() + std::size_t(pixel) * kMost; }
};

/// @param pictures  in one light; at least one, CV_8UC3, of one size.
/// @param radius  greatest distance of a channel from its cluster's mean, grey levels.
/// @cost  O(pictures x pixels); uses all cores, and the result does not depend on how many.
[[nodiscard]] ColourModes colour_modes(std::span<const cv::Mat> pictures, int radius);

}  // namespace choreo::vision
