// SPDX-License-Identifier: Apache-2.0
// Scripts without a motif: improvised small movements, and a walk through the picture.
#include <algorithm>

#include "devices/synthetic/chance.hpp"
#include "devices/synthetic/limbs.hpp"
#include "devices/synthetic/moves.hpp"

namespace choreo::devices::synthetic {
namespace {

using body::kLeft;
using body::kRight;
using body::Pose;

// A smooth curve through chance numbers from -1 to 1, one every `step` seconds.
double wander(std::uint64_t seed, std::uint64_t channel, double t, double step) {
  const double place = t / step + 16;
  const auto k = static_cast<std::uint64_t>(std::max(0.0, std::floor(place)));
  const double s = place - std::floor(place);
  const auto at = [&](std::uint64_t i) { return 2 * uniform(mixed(seed, 500 + channel, i)) - 1; };
  const double a = at(k), b = at(k + 1), c = at(k + 2), d = at(k + 3);
  // A uniform cubic B-spline: smoother than its knots, never beyond them.
  return ((1 - s) * (1 - s) * (1 - s) * a + (3 * s * s * s - 6 * s * s + 4) * b +
          (-3 * s * s * s + 3 * s * s + 3 * s + 1) * c + s * s * s * d) /
         6;
}

}  // namespace

Move make_idle(const ScriptOptions& options, const Style& style) {
  const auto seed = options.seed;
  return [=](double t) {
    const auto w = [&](std::uint64_t channel, double step) { return style.reach * wander(seed, channel, t, step); };
    Pose pose = standing(style);
    sway(pose, 0.07 * w(0, 1.1));
    pose.trunk_side = 12 * w(1, 0.9);
    pose.trunk_twist = 16 * w(2, 1.3);
    pose.neck_turn = 40 * w(3, 0.8);
    pose.neck_side = 12 * w(4, 0.9);
    for (const auto side : {kLeft, kRight}) {
      const std::uint64_t c = 10 + 10 * side;
      auto& arm = pose.arm[side];
      arm.abduction = 34 + 48 * w(c, 0.8);
      arm.flexion = 8 + 22 * w(c + 1, 1.0);
      arm.twist = -10 + 80 * w(c + 2, 1.2);
      arm.elbow = 52 + 72 * w(c + 3, 0.8);
      dip(pose.leg[side], 9 + 16 * w(c + 4, 1.2));
    }
    return body::grounded(pose);
  };
}

Move make_crossing(const ScriptOptions& options, const Style& style) {
  constexpr double kOnce = 6;       // seconds from side to side
  constexpr double kOutside = 0.5;  // units of H beyond the picture's edge
  constexpr double kStride = 0.86;  // two steps, in units of H
  const double way = options.half_width + kOutside;
  // Half a stride is left over, so that the way back begins on the other foot and mirrors the way there.
  const double strides = std::max(1.0, std::round(2 * way / kStride)) + 0.5;
  return [=](double t) {
    const double both = phase_of(t, 2 * kOnce) * 2;
    const bool back = both >= 1;
    const double u = back ? both - 1 : both;
    const double gait = u * strides;
    Pose pose = standing(style);
    pose.root.x() = way * (2 * u - 1);
    pose.heading = 78;
    pose.trunk_lean = 3;
    for (const auto side : {kLeft, kRight}) {
      const double g = gait + (side == kLeft ? 0.0 : 0.5);
      auto& leg = pose.leg[side];
      leg.abduction = 1;
      leg.flexion = 4 + 25 * wave_sin(g);
      // The knee bends while the thigh comes forward.
      const double swing = std::max(0.0, wave_cos(g));
      leg.knee = 6 + 50 * swing * swing;
      auto& arm = pose.arm[side];
      arm = {6, -26 * wave_sin(g), 0, 22 - 12 * wave_sin(g)};
    }
    return body::grounded(back ? body::mirrored(pose) : pose);
  };
}

}  // namespace choreo::devices::synthetic
