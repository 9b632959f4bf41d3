// SPDX-License-Identifier: Apache-2.0
// Which times an axis names, and how they are written.
#pragma once

#include <string>
#include <vector>

namespace choreo::outputs {

struct Tick {
  double at_s = 0.0;
  std::string label;  ///< Such as "0.5", "12", "1:30" or "2:05:00".
};

/// The ticks of a time axis, ascending.
struct TimeTicks {
  double step_s = 0.0;
  std::string unit;  ///< How the labels are to be read: "s", "min:s", "h:min", "h:min:s".
  std::vector<Tick> ticks;
};

/// Ticks at multiples of a round step: 1, 2, 5 times a power of ten below and up to two minutes; whole minutes and
/// hours beyond, where labels become m:ss (from 120 s on) and h:mm (from an hour on).
/// @param begin_s, end_s  finite, begin_s < end_s; both ends may carry a tick.
/// @param least_step_s    > 0: the step is the smallest round one that is not smaller.
[[nodiscard]] TimeTicks time_ticks(double begin_s, double end_s, double least_step_s);

/// A duration as a person would say it: "0.48 s", "51.2 s", "3 min 20 s", "1 h 4 min".
[[nodiscard]] std::string describe_duration(double seconds);

}  // namespace choreo::outputs
