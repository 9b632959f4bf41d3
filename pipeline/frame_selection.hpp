// SPDX-License-Identifier: Apache-2.0
// Which frames of a source are taken.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "core/time.hpp"

namespace choreo::pipeline {

/// `--span` and `--every`.
struct FrameSelection {
  // In seconds since the source's first frame, half open.
  Nanoseconds from{0};
  Nanoseconds to = Nanoseconds::max();
  // In the source's frames counted from 1, both ends in.
  std::uint64_t first_frame = 1;
  std::uint64_t last_frame = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t every = 1;  ///< The first of each `every` frames within the span.

  [[nodiscard]] bool before(std::uint64_t number, Nanoseconds time) const {
    return number < first_frame || time < from;
  }
  /// No later frame can be taken either.
  [[nodiscard]] bool past(std::uint64_t number, Nanoseconds time) const { return number > last_frame || time >= to; }
};

/// Reads `A:B`: in seconds ("1.5:3", "0:10s", "1min:") or in frames ("1f:468f"); either end may be left out.
/// @throws Error (usage) where it is neither, mixed, or empty because B is not behind A.
[[nodiscard]] FrameSelection parse_span(std::string_view text);

}  // namespace choreo::pipeline
