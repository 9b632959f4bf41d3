// SPDX-License-Identifier: Apache-2.0
// What scripts are made of: a pose as a function of time, and the few curves that lead from pose to pose.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "devices/synthetic/script.hpp"

namespace choreo::devices::synthetic {

/// A script's movement: its pose at a time in seconds from 0.
using Move = std::function<body::Pose(double)>;

/// What is true of a script, and how its movement is made.
struct ScriptEntry {
  ScriptFacts facts;
  Move (*make)(const ScriptOptions&, const Style&);  ///< Null: nobody.
};

/// One script a motif of docs/mathematics.
[[nodiscard]] std::vector<ScriptEntry> motif_scripts();
/// What people do: the six simple movements, then semaphore, idle, dancing, crossing, empty.
[[nodiscard]] std::vector<ScriptEntry> everyday_scripts();
/// How long semaphore takes, in seconds. @throws Error (usage) for a character that it cannot say.
[[nodiscard]] double semaphore_duration(const ScriptOptions& options);
[[nodiscard]] Move make_semaphore(const ScriptOptions& options, const Style& style);
[[nodiscard]] Move make_idle(const ScriptOptions& options, const Style& style);
[[nodiscard]] Move make_dancing(const ScriptOptions& options, const Style& style);
[[nodiscard]] Move make_crossing(const ScriptOptions& options, const Style& style);

/// Share of a period that has passed, in [0, 1). Rounded to 2^-30 so that a repetition repeats exactly.
[[nodiscard]] inline double phase_of(double seconds, double period) {
  const double periods = seconds / period;
  const double share = std::round((periods - std::floor(periods)) * 0x1p30) * 0x1p-30;
  return share >= 1 ? 0 : share;
}

/// 0 to 1 with no speed at either end; constant outside.
[[nodiscard]] inline double eased(double x) {
  const double t = x < 0 ? 0 : x > 1 ? 1 : x;
  return t * t * (3 - 2 * t);
}

/// Sine and cosine of a share of a full turn.
[[nodiscard]] inline double wave_sin(double turns) { return std::sin(2 * std::numbers::pi * turns); }
[[nodiscard]] inline double wave_cos(double turns) { return std::cos(2 * std::numbers::pi * turns); }

/// Standing at ease in somebody's style: symmetric.
[[nodiscard]] body::Pose standing(const Style& style);

/// A pose and when it is passed.
struct Key {
  double seconds = 0;
  body::Pose pose;
};

/// A smooth path through keys (rising times), resting at the first before and at the last after.
class Path {
 public:
  explicit Path(std::vector<Key> keys) : keys_(std::move(keys)) {}
  [[nodiscard]] body::Pose at(double seconds) const;

 private:
  std::vector<Key> keys_;
};

}  // namespace choreo::devices::synthetic
