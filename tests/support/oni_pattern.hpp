// SPDX-License-Identifier: Apache-2.0
// What the tests' own OpenNI2 camera sees: pictures that tell by themselves which one they are.
#pragma once

#include <cstdint>

namespace choreo::test {

inline constexpr int kOniWidth = 64, kOniHeight = 48, kOniFps = 30;
inline constexpr std::uint64_t kOniFirstUs = 1000000, kOniStepUs = 33333;
/// Depth is made a little later than colour.
inline constexpr std::uint64_t kOniDepthLateUs = 2000;

struct OniRgb {
  std::uint8_t r, g, b;
};

/// Colour of picture k: red is its number, green and blue are the place.
constexpr OniRgb oni_colour(int k, int x, int y) {
  return {static_cast<std::uint8_t>(k), static_cast<std::uint8_t>(4 * x), static_cast<std::uint8_t>(5 * y)};
}

/// Millimetres: a ramp that moves, with a column where nothing is known.
constexpr std::uint16_t oni_depth(int k, int x, int y) {
  return x == k % kOniWidth ? std::uint16_t{0} : static_cast<std::uint16_t>(600 + 10 * (k % 100) + 20 * x + y);
}

}  // namespace choreo::test
