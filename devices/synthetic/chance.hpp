// SPDX-License-Identifier: Apache-2.0
// Reproducible chance: numbers that depend only on what they are for, never on what was drawn before.
#pragma once

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <numbers>

namespace choreo::devices::synthetic {

/// A well mixed 64-bit number for a place in a four-dimensional table (the finaliser of splitmix64, once a coordinate).
[[nodiscard]] constexpr std::uint64_t mixed(std::uint64_t seed, std::uint64_t a, std::uint64_t b = 0,
                                            std::uint64_t c = 0) {
  std::uint64_t h = seed;
  for (const auto part : {a, b, c}) {
    h += 0x9e3779b97f4a7c15ULL + part;
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
    h ^= h >> 31;
  }
  return h;
}

/// Uniform in (0, 1).
[[nodiscard]] constexpr double uniform(std::uint64_t h) { return (static_cast<double>(h >> 11) + 0.5) * 0x1p-53; }

/// Normal with mean 0 and deviation 1 (Box and Muller).
[[nodiscard]] inline double normal(std::uint64_t h) {
  const double radius = std::sqrt(-2 * std::log(uniform(h)));
  return radius * std::cos(2 * std::numbers::pi * uniform(mixed(h, 1)));
}

}  // namespace choreo::devices::synthetic
