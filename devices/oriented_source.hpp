// SPDX-License-Identifier: Apache-2.0
// Turns and flips the frames of another source.
#pragma once

#include <memory>

#include "devices/source.hpp"

namespace choreo::devices {

/// One of the eight ways to hang a picture.
struct Orientation {
  int quarter_turns = 0;         ///< Clockwise, 0 to 3, applied first.
  bool flip_horizontal = false;  ///< Left becomes right.
  bool flip_vertical = false;    ///< Up becomes down.

  [[nodiscard]] bool is_identity() const { return quarter_turns == 0 && !flip_horizontal && !flip_vertical; }
  [[nodiscard]] bool swaps_sides() const { return quarter_turns % 2 != 0; }
};

/// The picture turned; a new picture unless the orientation is the identity.
[[nodiscard]] cv::Mat oriented(const cv::Mat& picture, const Orientation& orientation);

/// `source` with every frame turned.
[[nodiscard]] std::unique_ptr<Source> make_oriented(std::unique_ptr<Source> source, const Orientation& orientation);

}  // namespace choreo::devices
