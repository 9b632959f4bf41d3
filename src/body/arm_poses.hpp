// SPDX-License-Identifier: Apache-2.0
// Where a person's arms point, as the signs of semaphore count it.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "body/figure.hpp"

namespace choreo::body {

/// An arm in the picture's plane. Angles in degrees from straight down, towards the signaller's right: 90 is level on
/// the right, 180 up, 270 level on the left, so that semaphore's position k is 45 k; [0, 360).
struct ArmPose {
  double upper = 0;   ///< Shoulder to elbow.
  double fore = 0;    ///< Elbow to wrist.
  double length = 0;  ///< Of both in the picture, in torsos; about 1 where an arm lies in the picture's plane.
  double seen = 0;    ///< How likely nothing hides the wrist, 0 to 1; 0 where it lies beyond the picture.
  double spread = 0;  ///< Standard deviation of `fore` between looks, degrees.
};

/// Of each Side, the signaller's own. Nothing where shoulder, elbow and wrist are one place.
using ArmPoses = std::array<std::optional<ArmPose>, 2>;

/// What several looks at one picture tell together: the mean, and how far they are apart.
/// @param looks  at least one. An arm that one of them lacks is lacking.
[[nodiscard]] ArmPoses mean_of(std::span<const ArmPoses> looks);

/// A direction within [0, 360).
[[nodiscard]] double whole_turns_off(double degrees);

/// The difference between two directions, degrees in [-180, 180).
[[nodiscard]] double turn(double from, double to);

}  // namespace choreo::body
