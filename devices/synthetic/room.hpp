// SPDX-License-Identifier: Apache-2.0
// The empty room before which the performer stands.
#pragma once

#include <cstdint>

#include <opencv2/core.hpp>

#include "devices/synthetic/look.hpp"

namespace choreo::devices::synthetic {

/// Where the figure stands in the picture: x = centre_x + unit * x, y = floor_y - unit * y for body coordinates.
struct Stage {
  cv::Size size;
  double unit = 0;      ///< Pixels for the body's height.
  double centre_x = 0;  ///< Pixels from the left edge.
  double floor_y = 0;   ///< Pixels from the top edge.

  /// Half the picture's width in units of the body's height.
  [[nodiscard]] double half_width() const { return size.width / (2 * unit); }
};

/// The figure about three quarters of the picture's height, lower where a stretched-out body would not fit in width.
[[nodiscard]] Stage make_stage(cv::Size size);

/// Grey levels are kept as multiples of 1/32 so that faint light changes do not step.
inline constexpr int kLevelBits = 5;

/// Plaster, panelling, pictures, skirting board and floor. CV_16SC3, in 1/32 grey levels, `margin` pixels larger on
/// each side than the picture.
[[nodiscard]] cv::Mat paint_room(const Stage& stage, const Look& look, std::uint64_t seed, int margin);

}  // namespace choreo::devices::synthetic
