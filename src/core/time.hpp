// SPDX-License-Identifier: Apache-2.0
// Durations, time stamps and the clock that everything reads time from.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

namespace choreo {

using Nanoseconds = std::chrono::nanoseconds;

/// Seconds as a double, for results and for people.
[[nodiscard]] constexpr double to_seconds(Nanoseconds t) noexcept { return std::chrono::duration<double>(t).count(); }

/// The nearest nanosecond to a number of seconds.
[[nodiscard]] Nanoseconds from_seconds(double seconds) noexcept;

/// Reads a duration with its unit: "500ms", "1.5s", "10min", "2h"; a bare number is seconds.
/// @throws Error (usage) where the text is not a finite, non-negative duration below 1000 hours.
[[nodiscard]] Nanoseconds parse_duration(std::string_view text);

/// Where time is read from; tests use a simulated one and never sleep.
class Clock {
 public:
  virtual ~Clock() = default;
  /// Monotonic, of arbitrary origin.
  [[nodiscard]] virtual Nanoseconds now() const = 0;
};

}  // namespace choreo
