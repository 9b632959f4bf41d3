// SPDX-License-Identifier: Apache-2.0
// Whether a test may take its time.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <vector>

namespace choreo::test {

/// True in script/test --long, where a measurement covers all that it can; else it covers enough to fail where the code
/// is broken.
inline bool in_long_lane() { return std::getenv("CHOREO_LONG") != nullptr; }

/// All cases in the long lane; else `few` of them (2 or more), evenly spaced, the first and the last among them.
template <typename Case>
std::vector<Case> some_of(const std::vector<Case>& all, std::size_t few) {
  if (in_long_lane() || few >= all.size()) return all;
  std::vector<Case> some;
  for (std::size_t k = 0; k < few; ++k) some.push_back(all[k * (all.size() - 1) / std::max<std::size_t>(few - 1, 1)]);
  return some;
}

}  // namespace choreo::test
