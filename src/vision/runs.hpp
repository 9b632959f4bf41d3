// SPDX-License-Identifier: Apache-2.0
// Masks as runs of pixels: what is done with a mask's parts then costs as much as their outlines, not as the picture.
#pragma once

#include <cstdint>
#include <cstring>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace choreo::vision {

/// Pixels [from, to) of a line that are set.
struct Run {
  int y = 0;
  int from = 0;
  int to = 0;
};

/// Calls visit(from, to) for every run of a line, from left to right.
template <typename Visit>
void for_each_run(const std::uint8_t* line, int width, Visit visit) {
  int x = 0;
  while (x < width) {
    // Most of a picture is not set: eight pixels at a time.
    std::uint64_t eight = 0;
    while (x + 8 <= width) {
      std::memcpy(&eight, line + x, 8);
      if (eight != 0) break;
      x += 8;
    }
    while (x < width && line[x] == 0) ++x;
    if (x == width) return;
    const int from = x;
    while (x < width && line[x] != 0) ++x;
    visit(from, x);
  }
}

enum class Neighbours { kFour, kEight };

/// The runs of a mask and which connected part each belongs to.
struct Parts {
  std::vector<Run> runs;  ///< In reading order.
  std::vector<std::size_t>
      part_of;  ///< Of each run, 0 to `count` - 1; parts are in reading order of their first pixels.
  std::size_t count = 0;
};

/// @param mask  CV_8UC1, set where not 0.
/// @cost O(pixels) for finding the runs, then O(runs).
[[nodiscard]] Parts parts_of(const cv::Mat& mask, Neighbours neighbours);

}  // namespace choreo::vision
