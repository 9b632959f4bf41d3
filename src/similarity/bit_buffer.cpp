// SPDX-License-Identifier: Apache-2.0
#include "similarity/bit_buffer.hpp"

#include <cstdlib>
#include <cstring>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace choreo::similarity {
namespace {

constexpr std::size_t kHugePage = std::size_t{2} << 20;

std::uint8_t* allocate(std::size_t bytes) {
#ifdef __linux__
  // A history is read from end to end for every frame: with large pages a quarter faster, as the processor looks far
  // fewer addresses up. A wish, not a need: without them the memory is the same.
  if (bytes >= 2 * kHugePage) {
    const auto whole = (bytes + kHugePage - 1) / kHugePage * kHugePage;
    auto* bits = static_cast<std::uint8_t*>(std::aligned_alloc(kHugePage, whole));
    if (bits != nullptr) (void)madvise(bits, whole, MADV_HUGEPAGE);
    return bits;
  }
#endif
  return static_cast<std::uint8_t*>(std::aligned_alloc(kBitAlignment, bytes));
}

}  // namespace

BitBuffer make_bit_buffer(std::size_t bytes) {
  BitBuffer buffer(nullptr, [](std::uint8_t* bits) { std::free(bits); });
  if (bytes == 0) return buffer;
  buffer.reset(allocate(bytes));
  if (!buffer) throw std::bad_alloc();
  std::memset(buffer.get(), 0, bytes);
  return buffer;
}

}  // namespace choreo::similarity
