// SPDX-License-Identifier: Apache-2.0
// What the processor can do at most, in the same instruction set as the kernel under test.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace choreo::bench {

/// Both loops read `bytes` bytes, a multiple of 1024, aligned to 64, and return a number that depends on all of them.
struct Limits {
  /// AND with a register, population count, add.
  std::uint64_t (*and_count)(const std::uint8_t* stream, std::size_t bytes);
  /// Nothing but reading, into eight accumulators.
  std::uint64_t (*read)(const std::uint8_t* stream, std::size_t bytes);
};

/// Multiplications and additions of 32-bit floats a second that one core does in registers, in the best instruction
/// set.
[[nodiscard]] double multiply_add_rate();

/// @param kernel  the name of an AndCountKernel; "scalar" gets the loops of plain C++.
[[nodiscard]] Limits limits_of(const std::string& kernel);

}  // namespace choreo::bench
