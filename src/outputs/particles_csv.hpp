// SPDX-License-Identifier: Apache-2.0
// The arms and the particle state of every frame, as a table.
//
// Columns; a field is empty where there is nothing to say. Pixels are those of the working resolution, y down; lengths
// without a unit are face widths, y up.
//   frame, time_s                               the source's frames counted from 1; since its first frame
//   face_x_px, face_y_px, face_width_px, face_height_px   the face's box: left, top, width, height
//   arms                                        no_face, no_arm, one_arm, joined or two_arms
//   at_face, pieced                             0 or 1: an arm reaches into the face; was put together from pieces
//   then for the arm farther left (arm1; the only one, or both where joined) and the other (arm2)
//   arm1_area_px, arm1_x_px, arm1_y_px          area and centroid
//   arm1_cov_xx_px2, arm1_cov_xy_px2, arm1_cov_yy_px2   covariance
//   arm1_c_x, arm1_c_y                          (cov_xx - cov_yy, 2 cov_xy) / 2, face widths squared
//   arm1_zeta_0 to _2                           lift of c
//   and of the state, for joined and two_arms
//   alpha_x, alpha_y, nu_0 to nu_2, eta_x, eta_y, u_0 to u_2, psi_0 to psi_14
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "body/particle_state.hpp"
#include "vision/arms.hpp"
#include "vision/face.hpp"

namespace choreo::outputs {

/// One frame.
struct ParticleRow {
  std::uint64_t frame = 0;  ///< The source's frames counted from 1.
  double time_s = 0;        ///< Since the source's first frame.
  std::optional<vision::TrackedFace> face;
  vision::Arms arms;
  std::optional<body::ParticleState> state;  ///< Of these arms.
};

/// A header line and a line a frame, comma separated, as RFC 4180 with \n. Numbers of lengths in pixels have three
/// decimals, all others nine significant digits.
[[nodiscard]] std::string particles_csv(std::span<const ParticleRow> rows);

}  // namespace choreo::outputs
