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

/// The stage of a figure that stands elsewhere in that room. Farther away (distance above 1) its feet rise towards the
/// wall's foot; nearer the camera is raised, so that raised hands stay in the picture and the feet leave it.
/// @param distance  factor; the figure is drawn with 1 / distance of the size.
/// @param place     to the right, in widths of the picture.
[[nodiscard]] Stage moved_stage(const Stage& stage, double distance, double place);

/// The stage as a camera sees it whose picture is enlarged about its centre.
[[nodiscard]] Stage zoomed_stage(const Stage& stage, double zoom);

/// Plaster, panelling, furniture, skirting board and floor. CV_16SC3, in 1/32 grey levels, `margin` pixels larger on
/// each side than the picture.
/// @param anchored  the plaster is the same whatever the margin.
[[nodiscard]] cv::Mat paint_room(const Stage& stage, const Look& look, const Scene& scene, std::uint64_t seed,
                                 int margin, bool anchored);

}  // namespace choreo::devices::synthetic
