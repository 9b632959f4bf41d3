// SPDX-License-Identifier: Apache-2.0
// Short words for the postures that scripts are put together from.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "body/figure.hpp"

namespace choreo::devices::synthetic {

/// An arm held in the picture's plane, bent upwards by `elbow`.
inline void hold_arm(body::Pose& pose, body::Side side, double abduction, double elbow = 8) {
  pose.arm[side] = {abduction, 0, 90, elbow};
}

/// A hand on the hip, the elbow out to the side.
inline void akimbo(body::Pose& pose, body::Side side) { pose.arm[side] = {46, 0, -90, 87}; }

/// Moves the pelvis sideways over standing feet; positive to the performer's left.
inline void sway(body::Pose& pose, double x) {
  using namespace body::vitruvian;
  const double degrees = std::asin(std::clamp(x / (kThigh + kShank), -1.0, 1.0)) * 180 / std::numbers::pi;
  pose.root.x() += x;
  pose.leg[body::kLeft].abduction -= degrees;
  pose.leg[body::kRight].abduction += degrees;
}

/// Bends a leg that stays under the body with its foot flat: what a small knee bend looks like from the front.
inline void dip(body::LegAngles& leg, double thigh) {
  // Thigh and shank differ in length; the ankle stays under the hip.
  using namespace body::vitruvian;
  const double shank = std::asin(std::sin(thigh * std::numbers::pi / 180) * kThigh / kShank) * 180 / std::numbers::pi;
  leg.flexion = thigh;
  leg.knee = thigh + shank;
  leg.ankle = -shank;
}

/// Both legs apart and turned out, feet flat, the hips lowered by a share of their height: a plie.
/// @param apart  of an ankle from under its hip joint, in units of H, below 0.4.
inline void plie(body::Pose& pose, double apart, double lowered) {
  using namespace body::vitruvian;
  constexpr double kDegrees = 180 / std::numbers::pi;
  const double straight = kThigh + kShank;
  const double height = std::sqrt(straight * straight - apart * apart) * (1 - lowered);
  const double span = std::min(straight, std::hypot(apart, height));
  const auto angle = [](double near_a, double near_b, double far) {
    return std::acos(std::clamp((near_a * near_a + near_b * near_b - far * far) / (2 * near_a * near_b), -1.0, 1.0)) *
           kDegrees;
  };
  for (auto& leg : pose.leg) {
    leg.abduction = std::atan2(apart, height) * kDegrees + angle(kThigh, span, kShank);
    leg.flexion = 0;
    leg.twist = 90;
    leg.knee = 180 - angle(kThigh, kShank, span);
    leg.ankle = leg.abduction - leg.knee;
  }
}

}  // namespace choreo::devices::synthetic
