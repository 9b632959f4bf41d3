// SPDX-License-Identifier: Apache-2.0
// Makes a recording's time stamps strictly increasing where they are not.
#pragma once

#include <cstdint>
#include <optional>

#include "core/time.hpp"

namespace choreo::devices {

/// Passes good time stamps through unchanged and mends the others.
///
/// A stamp later than everything delivered so far is good. Otherwise, in this order:
/// - missing: one nominal frame duration after the previous frame;
/// - later than the previous frame's own stamp: as much later than the previous frame (a recording whose clock began
///   anew, as in joined files, keeps its variable frame rate);
/// - equal to the previous frame's own stamp: the smallest step after it;
/// - earlier: half a nominal duration after the previous frame, so that a single stray stamp does not push the next
///   good one aside.
class Timeline {
 public:
  /// @param nominal   declared frame duration; zero where none is declared, then `smallest` takes its place.
  /// @param smallest  one unit of the file's time base, at least 1 ns.
  Timeline(Nanoseconds nominal, Nanoseconds smallest);

  [[nodiscard]] Nanoseconds next(std::optional<Nanoseconds> stamp);

  /// How many stamps were mended so far.
  [[nodiscard]] std::uint64_t mended() const { return mended_; }

 private:
  Nanoseconds nominal_;
  Nanoseconds smallest_;
  std::optional<Nanoseconds> previous_;
  std::optional<Nanoseconds> previous_stamp_;
  std::uint64_t mended_ = 0;
};

}  // namespace choreo::devices
