// SPDX-License-Identifier: Apache-2.0
// Reads the list of pictures of a Kinect's dump, INDEX.txt.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/time.hpp"

namespace choreo::devices::kinect_dump {

/// A line of the index: "r-1290450193.124921-3431872.ppm".
struct Picture {
  std::string name;         ///< Of a file in the folder itself.
  Nanoseconds time{0};      ///< The recording host's clock.
  std::uint32_t ticks = 0;  ///< The Kinect's own, of 60 MHz; wraps after 71 s.
};

/// What a dump consists of. Times increase strictly within each stream.
struct Index {
  std::vector<Picture> colour;
  std::vector<Picture> depth;
  std::size_t late = 0;  ///< Pictures left out because their time does not lie after that of the one before.
  bool cut_off = false;  ///< The last line has no end, and was left out.
};

/// Names are T-SECONDS-TICKS.EXTENSION, one a line, LF only, T being r (colour), d (depth) or a (acceleration, not
/// looked at): whatever could lead out of the folder is no such name.
/// @param where  the file's path, for messages.
/// @throws Error (usage) with the line on anything else, and on times more than a day apart.
[[nodiscard]] Index parse_index(std::string_view text, const std::string& where);

/// Whether a file that begins so is an index: its first line is such a name.
[[nodiscard]] bool looks_like_index(std::string_view beginning);

/// Half the time between two pictures.
inline constexpr Nanoseconds kPairWithin{16'666'667};

/// Which depth picture belongs to which colour picture: those that are each other's nearest, at most `kPairWithin`
/// apart; of two equally near ones the earlier.
/// @return places in `colour` and in `depth`, both increasing.
/// @cost O(colour + depth).
[[nodiscard]] std::vector<std::pair<std::size_t, std::size_t>> pairs_by_time(const Index& index);

}  // namespace choreo::devices::kinect_dump
