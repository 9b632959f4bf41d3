// SPDX-License-Identifier: Apache-2.0
// From what the person network saw to where the arms point.
#pragma once

#include <opencv2/core/types.hpp>

#include "body/arm_poses.hpp"
#include "vision/person/person.hpp"

namespace choreo::pipeline {

/// What one look tells; nothing of who faces away (PersonLook::faces_away). Angles are turned by half of what the shoulders lean (at most 30 degrees): a camera that is
/// held askew leans them by all of that, an arm that is raised lifts its own shoulder.
/// @param picture   its size; joints of `look` are in its pixels.
/// @param mirrored  the picture is a mirror image, and the person's left arm is really the right one.
[[nodiscard]] body::ArmPoses arm_poses(const vision::PersonLook& look, cv::Size picture, bool mirrored = false);

}  // namespace choreo::pipeline
