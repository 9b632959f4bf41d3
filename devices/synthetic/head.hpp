// SPDX-License-Identifier: Apache-2.0
// Draws the performer's head: skull, hair, ears and a face.
#pragma once

#include <Eigen/Core>

#include "devices/synthetic/brush.hpp"
#include "devices/synthetic/look.hpp"

namespace choreo::devices::synthetic {

/// @param crown, chin  in picture coordinates.
/// @param axes         of the head: left, up and forward in body coordinates.
/// @param unit         pixels for the body's height.
void draw_head(Brush& brush, cv::Point2d chin, cv::Point2d crown, const Eigen::Matrix3d& axes, double unit,
               const Look& look);

}  // namespace choreo::devices::synthetic
