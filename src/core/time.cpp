// SPDX-License-Identifier: Apache-2.0
#include "core/time.hpp"

#include <cmath>

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/text.hpp"

namespace choreo {

Nanoseconds from_seconds(double seconds) noexcept { return Nanoseconds(std::llround(seconds * 1e9)); }

Nanoseconds parse_duration(std::string_view text) {
  struct Unit {
    std::string_view name;
    double seconds;
  };
  // "ms" and "min" stand before the single letters they end or begin with.
  static constexpr Unit kUnits[] = {{"ms", 1e-3}, {"us", 1e-6}, {"min", 60}, {"s", 1}, {"m", 60}, {"h", 3600}};
  constexpr double kMostSeconds = 1000.0 * 3600.0;

  auto number = text;
  double unit = 1.0;
  for (const auto& u : kUnits) {
    if (text.ends_with(u.name)) {
      number.remove_suffix(u.name.size());
      unit = u.seconds;
      break;
    }
  }
  const auto value = parse_number(number);
  if (!value || *value < 0 || *value * unit > kMostSeconds) {
    throw usage_error(fmt::format("\"{}\" is not a duration", text), {},
                      "write a number of seconds or one with a unit, such as 500ms, 1.5s or 10min");
  }
  return from_seconds(*value * unit);
}

}  // namespace choreo
