// SPDX-License-Identifier: Apache-2.0
// Draws the figure with its clothes, hair and face.
#pragma once

#include "body/figure.hpp"
#include "devices/synthetic/brush.hpp"
#include "devices/synthetic/look.hpp"
#include "devices/synthetic/room.hpp"

namespace choreo::devices::synthetic {

/// Lays the brush over the figure's part of the picture and draws the figure, the far parts first.
/// @param shift  pixels by which the camera displaces everything.
/// @return false where nothing of the figure can be inside the picture; the brush is then untouched.
bool draw_figure(Brush& brush, const body::Pose& pose, const Look& look, const Stage& stage, cv::Point2d shift);

}  // namespace choreo::devices::synthetic
