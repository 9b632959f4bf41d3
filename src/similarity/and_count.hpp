// SPDX-License-Identifier: Apache-2.0
// How many bits two bit strings have in common: the hot loops of mask similarity, for every instruction set.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace choreo::similarity {

/// Bit strings are padded with zero bits to a multiple of this many bytes, and aligned to it.
inline constexpr std::size_t kBitAlignment = 64;

/// Adds popcount(row & straight) to counts[0] and popcount(row & mirrored) to counts[1]: one reading of the row, which
/// may come from memory, gives both.
///
/// @param row  aligned to kBitAlignment.
/// @param straight, mirrored  any alignment.
/// @param bytes  length of all three, a multiple of kBitAlignment.
/// @param next  where the row after this one begins, or any valid address: its bytes are asked for while these are
///   counted, because the processor foresees the stream only within a row.
using AndCountTwice = void (*)(const std::uint8_t* row, const std::uint8_t* straight, const std::uint8_t* mirrored,
                               std::size_t bytes, const std::uint8_t* next, std::uint32_t* counts);

/// How many masks are counted side by side.
inline constexpr std::size_t kRunLanes = 32;

/// How many 16-bit sums a line of so many bytes has: one before every pixel, in kRunLanes lanes; one more after the
/// last; and at either side one more of the same value.
[[nodiscard]] constexpr std::size_t sums_per_line(std::size_t line_bytes) { return (8 * line_bytes + 3) * kRunLanes; }

/// Sums up the pixels of kRunLanes masks from the left: place 1 + x of a line holds how many pixels lie left of x.
///
/// @param columns  lines x line_bytes x kRunLanes bytes: bit k of byte b is the pixel at x = 8 b + k.
/// @param line_bytes  at most 8191, so that a sum fits.
/// @param sums  lines x sums_per_line(line_bytes), aligned to kBitAlignment.
using RunSums = void (*)(const std::uint8_t* columns, std::size_t line_bytes, std::size_t lines, std::uint16_t* sums);

/// Adds sum over k of (sums[places[2 k + 1] + lane] - sums[places[2 k] + lane]) to counts[lane], in every lane.
///
/// @param sums  at a multiple of kRunLanes places from an address aligned to kBitAlignment.
/// @param places  count numbers, an even many: begin and end of every run, multiples of kRunLanes. What one call adds
///   is less than 65,536.
using RunCount = void (*)(const std::uint16_t* sums, const std::uint32_t* places, std::size_t count,
                          std::uint32_t* counts);

/// One implementation of the loops.
struct AndCountKernel {
  /// The instruction set as Highway names it ("AVX2", "SSE4", ...), or "scalar" for the specification. Asked of the
  /// compiled code itself, so that it is the name of what runs.
  std::string name;
  AndCountTwice twice;
  RunSums sums;
  RunCount runs;
};

/// The specification: one pair, word by word.
[[nodiscard]] std::uint32_t and_count_scalar(const std::uint8_t* a, const std::uint8_t* b, std::size_t bytes);

/// What is compiled in and this machine can run, best first; the last is the specification.
[[nodiscard]] std::vector<AndCountKernel> and_count_kernels();

/// The kernel of that name; the best one for an empty name.
/// @throws Error (usage) listing the names where there is none of that name here.
[[nodiscard]] AndCountKernel choose_and_count(const std::string& name = {});

}  // namespace choreo::similarity
