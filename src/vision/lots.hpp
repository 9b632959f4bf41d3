// SPDX-License-Identifier: Apache-2.0
// Numbers without any order that are the same on every run.
#pragma once

#include <cstdint>

namespace choreo::vision {

/// The lot of a number: the same for the same number, evenly spread over all of 64 bits, and without any order.
/// @source Steele, Lea, Flood, Fast splittable pseudorandom number generators, OOPSLA 2014 (SplitMix64).
[[nodiscard]] constexpr std::uint64_t lot_of(std::uint64_t number) {
  std::uint64_t z = (number + 1) * 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace choreo::vision
