// SPDX-License-Identifier: Apache-2.0
// Whether a test may take its time.
#pragma once

#include <cstdlib>

namespace choreo::test {

/// True in script/test --long, where a measurement covers all that it can; else it covers enough to fail where the code
/// is broken.
inline bool in_long_lane() { return std::getenv("CHOREO_LONG") != nullptr; }

}  // namespace choreo::test
