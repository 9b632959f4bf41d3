// SPDX-License-Identifier: Apache-2.0
// The real clock.
#pragma once

#include "core/time.hpp"

namespace choreo::pipeline {

class SteadyClock final : public Clock {
 public:
  [[nodiscard]] Nanoseconds now() const override {
    return std::chrono::duration_cast<Nanoseconds>(std::chrono::steady_clock::now().time_since_epoch());
  }
};

}  // namespace choreo::pipeline
