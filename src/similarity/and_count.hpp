// SPDX-License-Identifier: Apache-2.0
// How many bits two bit strings have in common: the one hot loop of mask similarity, for every instruction set.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace choreo::similarity {

/// Bit strings are padded with zero bits to a multiple of this many bytes, and aligned to it.
inline constexpr std::size_t kBitAlignment = 64;

/// Rows and columns of one call of `and_count_block`.
inline constexpr std::size_t kBlockRows = 2;
inline constexpr std::size_t kBlockCols = 2;

/// Adds popcount(rows[i * kBlockCols + j] & cols[j]) to counts[i * kBlockCols + j], a block of pairs at once.
///
/// @param rows  kBlockRows x kBlockCols pointers: row i's bit string as the pair (i, j) needs it. For Z they are the
///   same along j; the mirror's shift makes them differ now and then.
/// @param cols  kBlockCols pointers.
/// @param bytes  length of every string, a multiple of kBitAlignment.
using AndCountBlock = void (*)(const std::uint8_t* const* rows, const std::uint8_t* const* cols, std::size_t bytes,
                               std::uint32_t* counts);

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

/// One implementation of the loops.
struct AndCountKernel {
  /// The instruction set as Highway names it ("AVX2", "SSE4", ...), or "scalar" for the specification. Asked of the
  /// compiled code itself, so that it is the name of what runs.
  std::string name;
  AndCountBlock block;
  AndCountTwice twice;
};

/// The specification: one pair, word by word.
[[nodiscard]] std::uint32_t and_count_scalar(const std::uint8_t* a, const std::uint8_t* b, std::size_t bytes);

/// What is compiled in and this machine can run, best first; the last is the specification.
[[nodiscard]] std::vector<AndCountKernel> and_count_kernels();

/// The kernel of that name; the best one for an empty name.
/// @throws Error (usage) listing the names where there is none of that name here.
[[nodiscard]] AndCountKernel choose_and_count(const std::string& name = {});

}  // namespace choreo::similarity
