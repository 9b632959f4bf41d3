// SPDX-License-Identifier: Apache-2.0
// Memory for bit strings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "similarity/and_count.hpp"

namespace choreo::similarity {

/// Owns bytes aligned to kBitAlignment.
using BitBuffer = std::unique_ptr<std::uint8_t[], void (*)(std::uint8_t*)>;

/// @param bytes  a multiple of kBitAlignment, all zero at first; none for 0. Throws std::bad_alloc.
[[nodiscard]] BitBuffer make_bit_buffer(std::size_t bytes);

/// The next multiple of kBitAlignment.
[[nodiscard]] constexpr std::size_t padded(std::size_t bytes) {
  return (bytes + kBitAlignment - 1) / kBitAlignment * kBitAlignment;
}

}  // namespace choreo::similarity
