// SPDX-License-Identifier: Apache-2.0
// Waits for what another thread or process does.
#pragma once

#include <chrono>
#include <thread>

namespace choreo::test {

/// Asks until the condition holds. @return whether it did within the limit, a guard against hanging only.
template <typename Condition>
[[nodiscard]] bool eventually(Condition condition, std::chrono::seconds limit = std::chrono::seconds(60)) {
  const auto until = std::chrono::steady_clock::now() + limit;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > until) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

}  // namespace choreo::test
