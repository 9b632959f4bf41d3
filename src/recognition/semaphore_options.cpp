// SPDX-License-Identifier: Apache-2.0
#include "recognition/semaphore_options.hpp"

#include <fmt/format.h>

#include "core/error.hpp"

namespace choreo::recognition {
namespace {

void check(const char* what, double value, double least, double most, const char* unit) {
  // Not "outside", so that what is no number is refused too.
  if (value >= least && value <= most) return;
  throw usage_error(fmt::format("{} \"{}\" is out of range", what, value), "semaphore",
                    fmt::format("from {} to {}{}", least, most, unit));
}

}  // namespace

void SemaphoreOptions::validate() const {
  check("least_similarity", least_similarity, 0.5, 0.999, "");
  check("margin", margin, 0, 0.5, "");
  check("hysteresis", hysteresis, 0, 0.5, "");
  check("hold_s", hold_s, 0.05, 5, " seconds");
  check("still_widths_s", still_widths_s, 0.05, 50, " face widths a second");
  check("still_degrees_s", still_degrees_s, 0.1, 500, " degrees a second");
  check("bridge_s", bridge_s, 0, 5, " seconds");
  check("word_gap", word_gap, 0.05, 20, " letters");
}

}  // namespace choreo::recognition
