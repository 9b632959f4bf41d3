// SPDX-License-Identifier: Apache-2.0
// Scripts without a motif: improvised small movements and dances, and a walk through the picture.
#include <algorithm>
#include <array>
#include <cmath>

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

// Where the arms rest in a dance: never at a sign of the semaphore alphabet, which any two straight arms are that point
// to different multiples of 45 degrees.
std::array<body::ArmAngles, 2> resting_arms(std::uint64_t seed, std::uint64_t k) {
  const auto chance = [&](std::uint64_t what) { return uniform(mixed(seed, 600 + what, k)); };
  const auto between = [&](std::uint64_t what, double least, double most) {
    return least + (most - least) * chance(what);
  };
  const auto off = [&](std::uint64_t what) { return (chance(what) < 0.5 ? -1 : 1) * between(what + 1, 18, 27); };
  constexpr double kBent = 4;  // a straight arm's elbow
  std::array<body::ArmAngles, 2> arms;
  const double kind = chance(0);
  if (kind < 0.75) {
    for (const auto side : {kLeft, kRight}) {
      const std::uint64_t c = 10 + 10 * side;
      auto& arm = arms[side];
      if (kind < 0.35) {
        arm = {between(c, 5, 180), between(c + 1, -8, 25), 90, kBent};
      } else {  // near a position
        arm = {45 * std::floor(between(c, 0, 5)) + between(c + 1, -9, 9), 0, 90, kBent};
      }
    }
    // At least one arm is well off every position.
    const auto odd = chance(1) < 0.5 ? kLeft : kRight;
    auto& abduction = arms[odd].abduction;
    abduction = 45 * std::round(abduction / 45) + off(2);
    if (abduction < -20) abduction += 45;
  } else if (kind < 0.81) {
    arms.fill({48, 0, -90, 95});  // hands on the hips
  } else if (kind < 0.87) {
    arms.fill({between(5, 95, 115), 0, 90, 125});  // behind the head
  } else if (kind < 0.93) {
    arms.fill({176, 0, 90, 2});  // both straight up
  } else {
    arms.fill({18, between(5, 30, 70), -60, 105});  // before the chest
  }
  return arms;
}

}  // namespace

Move make_dancing(const ScriptOptions& options, const Style& style) {
  const auto seed = options.seed;
  return [=](double t) {
    constexpr double kBeat = 1.7;  // seconds from posture to posture of the arms
    const auto chance = [&](std::uint64_t what, std::uint64_t k) { return uniform(mixed(seed, 640 + what, k)); };
    const auto w = [&](std::uint64_t channel, double step) {
      return style.reach * wander(seed, 40 + channel, t, step);
    };
    const auto k = static_cast<std::uint64_t>(std::max(0.0, std::floor(t / kBeat)));
    // Every posture is reached after a part of its beat, or only at its end: then the arms pass through it.
    const double part = chance(0, k) < 0.3 ? 1 : 0.35 + 0.4 * chance(1, k);
    const double moved = eased((t / kBeat - static_cast<double>(k)) / part);
    Pose pose = standing(style);
    Pose before = pose, after = pose;
    if (k > 0) before.arm = resting_arms(seed, k);
    after.arm = resting_arms(seed, k + 1);
    pose.arm = body::blended(before, after, moved).arm;
    sway(pose, 0.06 * w(0, 0.9));
    pose.trunk_side = 9 * w(1, 0.8);
    pose.trunk_twist = 10 * w(2, 1.1);
    pose.neck_turn = 30 * w(3, 0.9);
    pose.neck_side = 10 * w(4, 0.8);
    // The arms keep their directions while the trunk leans.
    pose.arm[kLeft].abduction += pose.trunk_side;
    pose.arm[kRight].abduction -= pose.trunk_side;
    for (const auto side : {kLeft, kRight}) dip(pose.leg[side], 12 + 20 * w(5 + side, 0.7));
    return body::grounded(pose);
  };
}

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
