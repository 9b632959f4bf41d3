// SPDX-License-Identifier: Apache-2.0
// How often memory was asked for, in programs that link allocations.cpp.
#pragma once

#include <cstddef>

namespace choreo::test {

/// The sanitizers watch allocations by taking `operator new` themselves.
#if defined(CHOREO_SANITIZED)
inline constexpr bool kAllocationsAreCounted = false;
#else
inline constexpr bool kAllocationsAreCounted = true;
#endif

/// Calls of `operator new` by this thread so far.
[[nodiscard]] std::size_t allocations();

}  // namespace choreo::test
