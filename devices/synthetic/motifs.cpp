// SPDX-License-Identifier: Apache-2.0
// One script for each motif of Z and Z*.
#include "devices/synthetic/limbs.hpp"
#include "devices/synthetic/moves.hpp"

namespace choreo::devices::synthetic {
namespace {

using body::kLeft;
using body::kRight;
using body::Pose;

// Standing with the arms in the picture's plane: left and right in degrees, the trunk to the left, the pelvis too.
Pose figure_of(const Style& style, double left, double right, double left_elbow, double right_elbow, double side = 0,
               double sideways = 0) {
  Pose pose = standing(style);
  hold_arm(pose, kLeft, left * style.reach, left_elbow);
  hold_arm(pose, kRight, right * style.reach, right_elbow);
  pose.trunk_side = side;
  pose.neck_side = -side / 3;
  sway(pose, sideways);
  return pose;
}

Pose with_hand_on_hip(Pose pose, body::Side side) {
  akimbo(pose, side);
  return pose;
}

Pose with_plie(Pose pose, double apart, double lowered) {
  plie(pose, apart, lowered);
  return pose;
}

Pose with_knee_up(Pose pose, body::Side side, double lift) {
  pose.leg[side] = {20, lift, 45, lift * 1.35, 15};
  return pose;
}

Move make_stillness(const ScriptOptions&, const Style& style) {
  const auto pose = body::grounded(with_hand_on_hip(figure_of(style, 128, 0, 14, 0, -8, -0.03), kRight));
  return [pose](double) { return pose; };
}

Move make_state_repetition(const ScriptOptions&, const Style& style) {
  const auto there = figure_of(style, 95, 150, 80, 10, 10, 0.02);
  const Path path({{0, figure_of(style, 20, 60, 10, 10)},
                   {2, there},
                   {3, with_plie(figure_of(style, 30, 100, 40, 85), 0.16, 0.2)},
                   {4.2, with_knee_up(figure_of(style, 60, 20, 20, 10, -18, -0.03), kLeft, 50)},
                   {5.6, with_hand_on_hip(figure_of(style, 168, 0, 5, 0, -16, -0.04), kRight)},
                   {7, there},
                   {8.4, figure_of(style, 15, 88, 10, 6, -20, -0.06)},
                   {10, with_hand_on_hip(figure_of(style, 0, 40, 10, 10), kLeft)}});
  return [path](double t) { return body::grounded(path.at(t)); };
}

Move make_path_repetition(const ScriptOptions&, const Style& style) {
  const auto start = figure_of(style, 30, 15, 10, 10, 0, 0.02);
  const auto end = with_plie(figure_of(style, 160, 45, 10, 85, 14), 0.18, 0.22);
  const Path path({{0, start},
                   {0.8, figure_of(style, 30, 92, 30, 8, -14, -0.05)},
                   {1.6, with_hand_on_hip(figure_of(style, 0, 155, 0, 8, 12, 0.04), kLeft)},
                   {2.5, end}});
  const Path before({{0, figure_of(style, 10, 70, 10, 90)}, {1, start}});
  const Path back(
      {{0, end}, {1.2, with_knee_up(figure_of(style, 70, 100, 10, 20, 15, 0.05), kRight, 60)}, {2.5, start}});
  const Path after({{0, end}, {1.5, figure_of(style, 95, 20, 8, 8, 16, 0.05)}});
  return [=](double t) {
    if (t < 1) return body::grounded(before.at(t));
    if (t < 3.5) return body::grounded(path.at(t - 1));
    if (t < 6) return body::grounded(back.at(t - 3.5));
    if (t < 8.5) return body::grounded(path.at(t - 6));
    return body::grounded(after.at(t - 8.5));
  };
}

Move make_palindrome(const ScriptOptions&, const Style& style) {
  const Path path({{0, figure_of(style, 20, 45, 10, 10)},
                   {1.1, figure_of(style, 60, 150, 85, 10, 12, 0.03)},
                   {2.1, with_plie(figure_of(style, 150, 90, 10, 90, -6), 0.17, 0.22)},
                   {3.1, with_hand_on_hip(figure_of(style, 90, 0, 6, 0, 20, 0.06), kRight)},
                   {4, with_knee_up(figure_of(style, 40, 140, 60, 20, -10, -0.04), kLeft, 55)}});
  return [path](double t) { return body::grounded(path.at(4 - std::abs(t - 4))); };
}

Move make_symmetric_path(const ScriptOptions&, const Style& style) {
  const Path path({{0, figure_of(style, 12, 12, 8, 8)},
                   {1.3, figure_of(style, 92, 92, 6, 6)},
                   {2.6, with_plie(figure_of(style, 75, 75, 95, 95), 0.16, 0.15)},
                   {3.9, with_plie(figure_of(style, 150, 150, 10, 10), 0.20, 0.30)},
                   {5.2, with_hand_on_hip(with_hand_on_hip(figure_of(style, 0, 0, 0, 0), kLeft), kRight)},
                   {6.5, figure_of(style, 115, 115, 100, 100)},
                   {8, with_plie(figure_of(style, 55, 55, 10, 10), 0.13, 0.05)}});
  return [path](double t) { return body::grounded(path.at(t)); };
}

Move make_reflected_state(const ScriptOptions&, const Style& style) {
  const auto there = figure_of(style, 100, 150, 85, 8, 16, 0.05);
  const Path path({{0, with_hand_on_hip(figure_of(style, 0, 40, 0, 20), kLeft)},
                   {2, there},
                   {3.3, with_plie(figure_of(style, 20, 95, 20, 8, 4), 0.17, 0.22)},
                   {4.7, with_hand_on_hip(figure_of(style, 0, 70, 0, 90, 6), kLeft)},
                   {6, body::mirrored(there)},
                   {8, with_knee_up(figure_of(style, 90, 20, 10, 10, -6, -0.03), kLeft, 45)}});
  return [path](double t) { return body::grounded(path.at(t)); };
}

// Arms and knees a quarter of a period apart: a loop that is never run backwards.
Move make_symmetric_cycle(const ScriptOptions&, const Style& style) {
  return [style](double t) {
    const double u = phase_of(t, 2);
    Pose pose = figure_of(style, 84 - 70 * wave_cos(u), 84 - 70 * wave_cos(u), 10, 10);
    plie(pose, 0.17, 0.17 - 0.15 * wave_sin(u));
    return body::grounded(pose);
  };
}

Move make_asymmetric_cycle(const ScriptOptions&, const Style& style) {
  return [style](double t) {
    const double u = phase_of(t, 2);
    Pose pose = with_hand_on_hip(figure_of(style, 0, 0, 0, 6, -7 * wave_cos(u), 0.03 * wave_sin(u)), kLeft);
    pose.arm[kRight].abduction = 360 * u;
    pose.arm[kRight].flexion = 10;
    return body::grounded(pose);
  };
}

Move make_symmetric_palindrome(const ScriptOptions&, const Style& style) {
  return [style](double t) {
    const double down = 0.5 - 0.5 * wave_cos(phase_of(t, 2));
    Pose pose = figure_of(style, 15 + 140 * down, 15 + 140 * down, 8, 8);
    plie(pose, 0.17, 0.02 + 0.30 * down);
    return body::grounded(pose);
  };
}

Move make_asymmetric_palindrome(const ScriptOptions&, const Style& style) {
  return [style](double t) {
    const double up = 0.5 - 0.5 * wave_cos(phase_of(t, 1.6));
    const double lean = -16 + 32 * up;
    return body::grounded(with_hand_on_hip(figure_of(style, 0, 18 + 140 * up, 0, 8, lean, 0.05 * (up - 0.5)), kLeft));
  };
}

// One arm rises while the other falls; the body swings a quarter of a period later.
Move make_anti_phase(const ScriptOptions&, const Style& style) {
  return [style](double t) {
    const double u = phase_of(t, 2);
    const double arms = 62 * wave_cos(u);
    const double body_side = wave_sin(u);
    return body::grounded(figure_of(style, 80 + arms, 80 - arms, 8, 8, 20 * body_side, 0.07 * body_side));
  };
}

// The same with the body swinging along: every path is run both ways, through a symmetric pose in the middle.
Move make_anti_palindrome(const ScriptOptions&, const Style& style) {
  return [style](double t) {
    const double swing = wave_cos(phase_of(t, 2));
    return body::grounded(figure_of(style, 80 + 62 * swing, 80 - 62 * swing, 8, 8, -18 * swing, -0.06 * swing));
  };
}

// The arm falls ever faster, bounces off what it hits the way it came, and is taken up again by a longer way.
Move make_strike(const ScriptOptions&, const Style& style) {
  const auto at_height = [style](double height) {
    Pose pose = with_hand_on_hip(
        figure_of(style, 0, 40 + 122 * height, 0, 20 - 14 * height, -14 + 26 * height, 0.05 * (height - 0.5)), kLeft);
    return pose;
  };
  const Path again({{0, at_height(1)},
                    {0.6, with_hand_on_hip(with_plie(figure_of(style, 0, 70, 0, 110, 6), 0.15, 0.18), kLeft)},
                    {1.0, with_hand_on_hip(with_plie(figure_of(style, 0, 100, 0, 120, 8), 0.13, 0.08), kLeft)},
                    {1.6, at_height(1)}});
  return [=](double t) {
    constexpr double kFall = 0.3;
    const double s = phase_of(t, 2.5) * 2.5;
    const double from_impact = (s - 0.6) / kFall;
    if (std::abs(from_impact) > 1) return body::grounded(s < 0.6 ? at_height(1) : again.at(s - 0.9));
    const double left = 1 - std::abs(from_impact);
    return body::grounded(at_height(1 - left * left));
  };
}

ScriptFacts named(const char* name, const char* summary, double duration, Symmetry symmetry) {
  ScriptFacts facts;
  facts.name = name;
  facts.summary = summary;
  facts.duration = duration;
  facts.symmetry = symmetry;
  return facts;
}

}  // namespace

std::vector<ScriptEntry> motif_scripts() {
  std::vector<ScriptEntry> all;
  const auto add = [&](ScriptFacts facts, Move (*make)(const ScriptOptions&, const Style&)) -> ScriptFacts& {
    return all.emplace_back(ScriptEntry{std::move(facts), make}).facts;
  };
  add(named("stillness", "one asymmetric pose, held", 8, Symmetry::kNever), make_stillness).still = true;
  add(named("state-repetition", "a pose comes back by another way", 10, Symmetry::kNever), make_state_repetition)
      .same = {2, 7};
  auto& repetition =
      add(named("path-repetition", "a phrase of 2.5 s, danced twice", 10, Symmetry::kSometimes), make_path_repetition);
  repetition.repeated = {1, 6};
  repetition.length = 2.5;
  auto& palindrome =
      add(named("palindrome", "a phrase of 4 s and back again", 8, Symmetry::kSometimes), make_palindrome);
  palindrome.turn = 4;
  palindrome.reach = 4;
  add(named("symmetric-path", "symmetric poses, none twice", 8, Symmetry::kAlways), make_symmetric_path);
  add(named("reflected-state", "a pose and later its mirror image", 8, Symmetry::kNever), make_reflected_state)
      .mirrored = {2, 6};
  add(named("symmetric-cycle", "a symmetric loop, one way", 10, Symmetry::kAlways), make_symmetric_cycle).period = 2;
  add(named("asymmetric-cycle", "an asymmetric loop, one way", 10, Symmetry::kNever), make_asymmetric_cycle).period = 2;
  auto& squats = add(named("symmetric-palindrome", "a symmetric path to and fro", 10, Symmetry::kAlways),
                     make_symmetric_palindrome);
  squats.period = 2;
  squats.turn = squats.reach = 1;
  auto& waving = add(named("asymmetric-palindrome", "an asymmetric path to and fro", 9.6, Symmetry::kNever),
                     make_asymmetric_palindrome);
  waving.period = 1.6;
  waving.turn = waving.reach = 0.8;
  auto& anti_phase =
      add(named("anti-phase", "the mirror image half a period later, one way", 10, Symmetry::kNever), make_anti_phase);
  anti_phase.period = 2;
  anti_phase.mirror_shift = 1;
  auto& anti_palindrome =
      add(named("anti-palindrome", "to the mirror image and back through a symmetric pose", 10, Symmetry::kSometimes),
          make_anti_palindrome);
  anti_palindrome.period = 2;
  anti_palindrome.mirror_shift = 1;
  anti_palindrome.turn = anti_palindrome.reach = 1;
  anti_palindrome.mirror_turn = 1.5;
  auto& strike = add(named("strike", "falling blows that bounce back", 10, Symmetry::kNever), make_strike);
  strike.period = 2.5;
  strike.turn = 0.6;
  strike.reach = 0.3;
  return all;
}

}  // namespace choreo::devices::synthetic
