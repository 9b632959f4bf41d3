// SPDX-License-Identifier: Apache-2.0
// Memory for bit strings.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>

#include "similarity/and_count.hpp"

namespace choreo::similarity {

/// Owns bytes aligned to kBitAlignment.
using BitBuffer = std::unique_ptr<std::uint8_t[], void (*)(std::uint8_t*)>;

/// @param bytes  a multiple of kBitAlignment, all zero at first; none for 0.
[[nodiscard]] inline BitBuffer make_bit_buffer(std::size_t bytes) {
  BitBuffer buffer(nullptr, [](std::uint8_t* bits) { std::free(bits); });
  if (bytes == 0) return buffer;
  buffer.reset(static_cast<std::uint8_t*>(std::aligned_alloc(kBitAlignment, bytes)));
  if (!buffer) throw std::bad_alloc();
  std::memset(buffer.get(), 0, bytes);
  return buffer;
}

/// The next multiple of kBitAlignment.
[[nodiscard]] constexpr std::size_t padded(std::size_t bytes) {
  return (bytes + kBitAlignment - 1) / kBitAlignment * kBitAlignment;
}

}  // namespace choreo::similarity
