// SPDX-License-Identifier: Apache-2.0
// What every way of comparing a sequence of silhouettes needs to know of them.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <opencv2/core/types.hpp>

#include "body/mask_state.hpp"

namespace choreo::similarity {

using MaskStates = std::span<const std::unique_ptr<const body::MaskState>>;

/// Areas, centroids' remainders and the canvas of N silhouettes.
struct MaskTable {
  explicit MaskTable(MaskStates states);

  /// What the bodies occupy, in coordinates relative to the centroid, and a column more on either side, in which no
  /// mask has a bit: the mirror's shift by one pixel stays on the canvas. Empty where there is no body.
  cv::Rect canvas;
  std::vector<std::int64_t> areas;  ///< Pixels; 0: a gap.
  std::vector<std::int64_t> remainders;
  std::size_t runs = 0;  ///< Of body pixels along the lines of all masks together.

  [[nodiscard]] std::size_t size() const { return areas.size(); }
  [[nodiscard]] bool has_body(std::size_t i) const { return areas[i] > 0; }
  /// The mirror's sigma of a pair of bodies, -1, 0 or 1.
  [[nodiscard]] int shift(std::size_t i, std::size_t j) const {
    return body::mirror_shift(remainders[i], areas[i], remainders[j], areas[j]);
  }
  /// The similarity of a pair of bodies with so many pixels in common.
  [[nodiscard]] float similarity(std::uint32_t common, std::size_t i, std::size_t j) const {
    return static_cast<float>(body::similarity_of_counts(common, areas[i], areas[j]));
  }
};

/// 64 pixels of a mask's line (`MaskState::row`) from x = `first`, relative to the centroid, on: bit k is the pixel at
/// first + k, 0 outside the mask's box.
[[nodiscard]] inline std::uint64_t pixels_from(const body::MaskState& state, const std::uint64_t* line, int first) {
  const int k = first - state.box().x;
  const auto word = std::ptrdiff_t(k >> 6);
  const int shift = k & 63;
  const auto words = std::ptrdiff_t(state.row_words());
  const auto at = [&](std::ptrdiff_t i) { return i >= 0 && i < words ? line[i] : 0; };
  return shift == 0 ? at(word) : at(word) >> shift | at(word + 1) << (64 - shift);
}

/// Calls run(begin, end) for every run of body pixels [begin, end) along a line, relative to the centroid.
template <typename Run>
void for_each_run(const body::MaskState& state, const std::uint64_t* line, Run run) {
  int begin = 0;
  std::uint64_t before = 0;  // The pixel left of the word, in bit 0.
  const auto words = state.row_words();
  // One word more, which is 0, ends a run at the box's right side.
  for (std::size_t i = 0; i <= words; ++i) {
    const std::uint64_t word = i < words ? line[i] : 0;
    for (auto changes = word ^ (word << 1 | before); changes != 0; changes &= changes - 1) {
      const int k = std::countr_zero(changes);
      const int x = state.box().x + int(i) * 64 + k;
      if ((word >> k & 1) != 0) {
        begin = x;
      } else {
        run(begin, x);
      }
    }
    before = word >> 63;
  }
}

}  // namespace choreo::similarity
