// SPDX-License-Identifier: Apache-2.0
#include "support/allocations.hpp"

#include <cstdlib>
#include <new>

namespace {
thread_local std::size_t count = 0;
}  // namespace

namespace choreo::test {
std::size_t allocations() { return count; }
}  // namespace choreo::test

#if defined(CHOREO_SANITIZED)
// The sanitizers watch allocations by taking `operator new` themselves, and call this one of sanitizer/
// allocator_interface.h, a header that g++ does not bring along.
extern "C" void __sanitizer_malloc_hook(const volatile void* /*memory*/, std::size_t /*bytes*/) { ++count; }
#else
void* operator new(std::size_t bytes) {
  ++count;
  if (void* memory = std::malloc(bytes > 0 ? bytes : 1)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t /*bytes*/) noexcept { std::free(memory); }
#endif
