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
/// The face itself, without ears and the hair's outline, is marked `face_mark`.
void draw_head(Brush& brush, cv::Point2d chin, cv::Point2d crown, const Eigen::Matrix3d& axes, double unit,
               const Look& look, unsigned char face_mark = 1);

/// The upright box around the face, from cheek to cheek and from chin to hairline, in picture coordinates; what is seen
/// of it where the head is turned, nothing where it shows its back. Parameters as for draw_head.
[[nodiscard]] cv::Rect2d face_box(cv::Point2d chin, cv::Point2d crown, const Eigen::Matrix3d& axes, double unit);

}  // namespace choreo::devices::synthetic
