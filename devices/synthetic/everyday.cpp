// SPDX-License-Identifier: Apache-2.0
// The six simple movements of the thesis' motion graphs, and the list of what people do.
#include <algorithm>

#include "devices/synthetic/limbs.hpp"
#include "devices/synthetic/moves.hpp"

namespace choreo::devices::synthetic {
namespace {

using body::kLeft;
using body::kRight;
using body::Pose;

// 0 outside, rising to 1 and falling again between `from` and `to`.
double bump(double u, double from, double to) {
  if (u <= from || u >= to) return 0;
  const double s = wave_sin((u - from) / (to - from) / 2);
  return s * s;
}

// Up in front, straight; down by the sides, straight: the arms never go back the way they came.
Move make_butterfly(const ScriptOptions&, const Style& style) {
  return [style](double t) {
    constexpr double kUp = 0.42;
    constexpr double kClose = 10;  // degrees from vertical, hanging and overhead
    const double u = phase_of(t, 1.5);
    Pose pose = standing(style);
    for (auto& arm : pose.arm) {
      if (u < kUp) {
        const double share = u / kUp;
        arm = {kClose - 2 * kClose * share, 180 * share, 0, 4};
      } else {
        // Abduction 180 - x with the arm turned by 180 is flexion 180 with abduction -x: the arm is where it was.
        const double share = (u - kUp) / (1 - kUp);
        arm = {180 - kClose - (180 - 2 * kClose) * share, 0, 180 * (1 - eased(share)), 4};
      }
    }
    const double bent = 0.5 + 0.5 * wave_sin(u);
    for (auto& leg : pose.leg) dip(leg, 6 + 30 * style.reach * bent);
    pose.trunk_lean = 4 + 12 * bent;
    return body::grounded(pose);
  };
}

Move make_jumping_jacks(const ScriptOptions&, const Style& style) {
  return [style](double t) {
    // 0 with the hands at the thighs, 1 with the arms up and the feet apart; in between a leap.
    const double open = 0.5 - 0.5 * wave_cos(phase_of(t, 1));
    Pose pose = standing(style);
    for (const auto side : {kLeft, kRight}) {
      hold_arm(pose, side, 11 + 148 * style.reach * open, 6 + style.elbow * (1 - open));
      dip(pose.leg[side], 8 * (1 - open) * (1 - open));
      pose.leg[side].abduction = style.stance + 20 * style.reach * open;
    }
    return body::grounded(pose, 0.16 * open * (1 - open));
  };
}

// A leg that steps on the spot, seen from the front: the knee comes up and a little out.
void step(body::LegAngles& leg, double lift, const Style& style, double height) {
  leg.flexion += height * style.reach * lift;
  leg.knee += 1.45 * height * style.reach * lift;
  leg.twist += 26 * lift;
  leg.ankle += 18 * lift;
  leg.abduction += 6 * lift;
}

Move make_jogging(const ScriptOptions&, const Style& style) {
  return [style](double t) {
    const double u = phase_of(t, 0.8);
    const double left = bump(u, 0, 0.5);
    const double right = bump(u, 0.5, 1);
    Pose pose = standing(style);
    pose.trunk_lean = 6;
    sway(pose, -0.03 * (left - right));
    step(pose.leg[kLeft], left, style, 68);
    step(pose.leg[kRight], right, style, 68);
    // The hand opposite to the lifted knee comes up, its elbow out.
    const double swing = left - right;
    pose.arm[kLeft] = {30 - 8 * swing, 8 - 30 * swing, 30, 92 - 22 * swing};
    pose.arm[kRight] = {30 + 8 * swing, 8 + 30 * swing, 30, 92 + 22 * swing};
    pose.trunk_side = 5 * swing;
    pose.neck_side = -3 * swing;
    return body::grounded(pose, 0.03 * (left + right));
  };
}

// On the spot. The hips go ahead of the step and the arms behind it, so that no pose is symmetric and no path returns.
Move make_walking(const ScriptOptions&, const Style& style) {
  return [style](double t) {
    constexpr double kAhead = 0.12;
    const double u = phase_of(t, 1.2);
    Pose pose = standing(style);
    sway(pose, -0.045 * wave_sin(u + kAhead));
    pose.trunk_side = 6 * wave_sin(u + kAhead);
    step(pose.leg[kLeft], bump(u, 0.0, 0.5), style, 46);
    step(pose.leg[kRight], bump(u, 0.5, 1.0), style, 46);
    const double swing = style.reach * wave_sin(u - kAhead);
    pose.arm[kLeft] = {26 - 18 * swing, 6 - 24 * swing, 60, 22 - 10 * swing};
    pose.arm[kRight] = {26 + 18 * swing, 6 + 24 * swing, 60, 22 + 10 * swing};
    return body::grounded(pose);
  };
}

// The right leg stays stiff and is swung round by leaning away from it; the left one steps in a hurry.
Move make_limp(const ScriptOptions&, const Style& style) {
  return [style](double t) {
    const double u = phase_of(t, 1.4);
    const double quick = bump(u, 0.02, 0.36);
    const double lean = bump(u, 0.34, 0.94);
    const double swung = bump(u, 0.46, 0.98);
    Pose pose = standing(style);
    sway(pose, -0.035 * quick + 0.055 * lean);
    pose.trunk_side = -9 * quick + 17 * lean;
    pose.neck_side = 4 * quick - 8 * lean;
    step(pose.leg[kLeft], quick, style, 40);
    pose.leg[kRight].abduction += 22 * style.reach * swung;
    pose.leg[kRight].ankle -= 6 * swung;
    hold_arm(pose, kLeft, 22 + 42 * lean - 6 * quick, 14);
    pose.arm[kRight] = {16 + 12 * quick, 0, -60, 48};
    return body::grounded(pose);
  };
}

Move make_side_kicks(const ScriptOptions&, const Style& style) {
  const auto guard = [style](double left_leg, double lift, double knee, double lean) {
    Pose pose = standing(style);
    sway(pose, -0.05);
    pose.leg[kLeft] = {left_leg * style.reach, lift, 40, knee, 10};
    pose.trunk_side = lean;
    pose.neck_side = -lean / 2;
    pose.arm[kLeft] = {38, 20, 20, 100};
    pose.arm[kRight] = {34, 25, 10, 112};
    return pose;
  };
  Pose middle = standing(style);
  for (auto& arm : middle.arm) arm = {34, 24, 10, 110};
  for (auto& leg : middle.leg) {
    leg.abduction += 5;
    leg.twist = 8;
  }
  const Pose ready = guard(20, 28, 42, -6);
  const Path out({{0, middle}, {0.5, ready}});
  const Path kick({{0, ready},
                   {0.3, guard(48, 50, 96, -16)},
                   {0.55, guard(76, 6, 4, -38)},
                   {0.8, guard(42, 0, 8, -16)},
                   {1, ready}});
  return [=](double t) {
    const double s = phase_of(t, 6) * 6;
    const double half = s < 3 ? s : s - 3;
    Pose pose;
    if (half < 0.5) {
      pose = out.at(half);
    } else if (half < 2.5) {
      pose = kick.at(half < 1.5 ? half - 0.5 : half - 1.5);
    } else {
      pose = out.at(3 - half);
    }
    return body::grounded(s < 3 ? pose : body::mirrored(pose));
  };
}

}  // namespace

std::vector<ScriptEntry> everyday_scripts() {
  std::vector<ScriptEntry> all;
  const auto add = [&](const char* name, const char* summary, double duration, Symmetry symmetry,
                       Move (*make)(const ScriptOptions&, const Style&)) -> ScriptFacts& {
    ScriptFacts facts;
    facts.name = name;
    facts.summary = summary;
    facts.duration = duration;
    facts.symmetry = symmetry;
    return all.emplace_back(ScriptEntry{std::move(facts), make}).facts;
  };
  add("butterfly", "the arms' stroke of a swimmer: Xbar with a one-way loop", 9, Symmetry::kAlways, make_butterfly)
      .period = 1.5;
  auto& jacks = add("jumping-jacks", "Xbar <-> Ybar", 10, Symmetry::kAlways, make_jumping_jacks);
  jacks.period = 1;
  jacks.turn = jacks.reach = 0.5;
  auto& jogging = add("jogging", "on the spot: A <-> Xbar <-> A*", 9.6, Symmetry::kSometimes, make_jogging);
  jogging.period = 0.8;
  jogging.mirror_shift = 0.4;
  jogging.mirror_turn = 0.4;
  jogging.turn = 0.2;
  jogging.reach = 0.2;
  auto& walking = add("walking", "on the spot: A -> A* and A* -> A, one way each", 9.6, Symmetry::kNever, make_walking);
  walking.period = 1.2;
  walking.mirror_shift = 0.6;
  add("limp", "on the spot: A with a one-way loop, never its mirror image", 9.8, Symmetry::kNever, make_limp).period =
      1.4;
  auto& kicks =
      add("side-kicks", "A <-> Xbar <-> A*, with loops aa and (aa)*", 12, Symmetry::kSometimes, make_side_kicks);
  kicks.period = 6;
  kicks.mirror_shift = 3;
  kicks.mirror_turn = 3;
  kicks.reach = 0.5;
  kicks.repeated = {0.5, 1.5};
  kicks.length = 1;
  add("semaphore", "the flag alphabet, or text=", 130, Symmetry::kSometimes, make_semaphore);
  add("idle", "small improvised movements, other ones for every seed", 10, Symmetry::kSometimes, make_idle);
  add("dancing", "improvised, resting now and then near semaphore signs, at none", 120, Symmetry::kSometimes,
      make_dancing);
  auto& crossing = add("crossing", "walks through the picture and back", 12, Symmetry::kSometimes, make_crossing);
  crossing.period = 12;
  crossing.mirror_shift = 6;
  add("empty", "nobody: the room alone", 8, Symmetry::kSometimes, nullptr);
  return all;
}

}  // namespace choreo::devices::synthetic
