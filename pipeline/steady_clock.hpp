// SPDX-License-Identifier: Apache-2.0
// The real clock.
#pragma once

#include <condition_variable>
#include <mutex>
#include <stop_token>

#include "core/time.hpp"

namespace choreo::pipeline {

class SteadyClock final : public Clock {
 public:
  [[nodiscard]] Nanoseconds now() const override {
    return std::chrono::duration_cast<Nanoseconds>(std::chrono::steady_clock::now().time_since_epoch());
  }
};

/// Sleeps until a moment of SteadyClock. @return false where `stop` was requested before.
inline bool sleep_until(Nanoseconds moment, const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  const std::chrono::steady_clock::time_point when{
      std::chrono::duration_cast<std::chrono::steady_clock::duration>(moment)};
  never.wait_until(lock, stop, when, [] { return false; });
  return !stop.stop_requested();
}

}  // namespace choreo::pipeline
