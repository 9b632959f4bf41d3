// SPDX-License-Identifier: Apache-2.0
// One of the eight ways to hang a picture.
#pragma once

namespace choreo::devices {

/// One of the eight ways to hang a picture.
struct Orientation {
  int quarter_turns = 0;         ///< Clockwise, 0 to 3, applied first.
  bool flip_horizontal = false;  ///< Left becomes right.
  bool flip_vertical = false;    ///< Up becomes down.

  [[nodiscard]] bool is_identity() const { return quarter_turns == 0 && !flip_horizontal && !flip_vertical; }
  [[nodiscard]] bool swaps_sides() const { return quarter_turns % 2 != 0; }

  /// The one orientation that does this and then `next`; it never flips vertically, which half a turn and a horizontal
  /// flip do as well.
  [[nodiscard]] constexpr Orientation then(const Orientation& next) const {
    const auto plain = [](const Orientation& o) {
      return Orientation{(o.quarter_turns + (o.flip_vertical ? 2 : 0)) % 4, o.flip_horizontal != o.flip_vertical,
                         false};
    };
    const auto a = plain(*this);
    const auto b = plain(next);
    // A turn behind a horizontal flip is the opposite turn before it.
    const int turns = a.quarter_turns + (a.flip_horizontal ? 4 - b.quarter_turns : b.quarter_turns);
    return {turns % 4, a.flip_horizontal != b.flip_horizontal, false};
  }
};

}  // namespace choreo::devices
