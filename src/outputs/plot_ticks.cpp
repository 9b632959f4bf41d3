// SPDX-License-Identifier: Apache-2.0
#include "outputs/plot_ticks.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace choreo::outputs {
namespace {

constexpr double kMinutesFrom = 120.0;
constexpr double kHoursFrom = 3600.0;
/// A share of a step by which a tick may miss the end of the axis and still be on it.
constexpr double kOnTheEdge = 1e-6;

/// The smallest of 1, 2, 5 times a power of ten that is not below `least`.
double decimal_step(double least) {
  const double power = std::pow(10.0, std::floor(std::log10(least) + 1e-9));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= least * (1.0 - 1e-9)) return factor * power;
  }
  return 10.0 * power;
}

/// Minutes and hours have steps of their own.
double clock_step(double least) {
  if (least <= 5.0) return decimal_step(least);
  for (const double step : {10.0, 20.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1200.0, 1800.0}) {
    if (step >= least) return step;
  }
  return 3600.0 * decimal_step(std::max(1.0, least / 3600.0));
}

std::string clock_label(double seconds, double step, bool hours) {
  const int decimals = step < 1.0 ? static_cast<int>(std::ceil(-std::log10(step) - 1e-9)) : 0;
  const double scale = std::pow(10.0, decimals);
  const char* sign = seconds < 0 ? "-" : "";
  const double rounded = std::round(std::abs(seconds) * scale) / scale;
  const auto whole = static_cast<long long>(rounded + 0.5 / scale);
  const long long minutes = whole / 60;
  const double rest = std::max(0.0, rounded - static_cast<double>(minutes * 60));
  if (hours && step >= 60.0) return fmt::format("{}{}:{:02}", sign, minutes / 60, minutes % 60);
  const int width = decimals > 0 ? 3 + decimals : 2;
  const auto tail = fmt::format("{:0{}.{}f}", rest, width, decimals);
  if (hours) return fmt::format("{}{}:{:02}:{}", sign, minutes / 60, minutes % 60, tail);
  return fmt::format("{}{}:{}", sign, minutes, tail);
}

}  // namespace

TimeTicks time_ticks(double begin_s, double end_s, double least_step_s) {
  const double far = std::max(std::abs(begin_s), std::abs(end_s));
  const bool hours = far > kHoursFrom;
  const bool minutes = far > kMinutesFrom;
  TimeTicks result;
  result.step_s = minutes ? clock_step(least_step_s) : decimal_step(least_step_s);
  const double step = result.step_s;
  result.unit = !minutes ? "s" : !hours ? "min:s" : step < 60.0 ? "h:min:s" : "h:min";
  const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
  const auto first = std::llround(std::ceil(begin_s / step - kOnTheEdge));
  const auto last = std::llround(std::floor(end_s / step + kOnTheEdge));
  for (auto k = first; k <= last; ++k) {
    const double at = static_cast<double>(k) * step;
    result.ticks.push_back(
        {at, minutes ? clock_label(at, step, hours) : (k == 0 ? "0" : fmt::format("{:.{}f}", at, decimals))});
  }
  return result;
}

std::string describe_duration(double seconds) {
  if (seconds < 1.0) return fmt::format("{:.2g} s", seconds);
  if (seconds < 119.95) return fmt::format("{:.1f} s", seconds);
  const auto whole = std::llround(seconds);
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  const auto minutes = std::llround(seconds / 60.0);
  return fmt::format("{} h {} min", minutes / 60, minutes % 60);
}

}  // namespace choreo::outputs
