// SPDX-License-Identifier: Apache-2.0
// How often memory was asked for, in programs that link allocations.cpp.
#pragma once

#include <cstddef>

namespace choreo::test {

/// Calls of `operator new` by this thread so far; with the sanitizers, of malloc as well.
[[nodiscard]] std::size_t allocations();

}  // namespace choreo::test
