// SPDX-License-Identifier: Apache-2.0
// Which of a device's modes to take.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "devices/openni2/protocol.hpp"

namespace choreo::devices::openni2 {

struct ModeWish {
  std::uint32_t width = 0, height = 0;  ///< 0 is open: 640x480, or what is nearest to it.
  bool exactly = false;                 ///< No other size will do.
  std::uint32_t fps = 0;                ///< 0 is open: 30.
};

/// @param modes  those of format 0 cannot be read and are passed over.
/// @return of the modes with the size, else the nearest one, the one whose rate is nearest, then the one that loses the
///   least (RGB3, YUYV, UYVY, MJPG, GREY); of equals the first. Nothing where none fits.
[[nodiscard]] std::optional<std::size_t> choose_mode(std::span<const Mode> modes, const ModeWish& wish);

}  // namespace choreo::devices::openni2
