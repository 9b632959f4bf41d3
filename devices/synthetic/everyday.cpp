// SPDX-License-Identifier: Apache-2.0
// The six simple movements of the thesis' motion graphs.
#include <algorithm>

#include "devices/synthetic/moves.hpp"

namespace choreo::devices::synthetic {
namespace {

using body::kLeft;
using body::kRight;
using body::Pose;
using body::Side;

// 0 where the hands are at the thighs, 1 where they meet overhead and the feet are apart; in between a leap.
Move make_jumping_jacks(const ScriptOptions&, const Style& style) {
  return [style](double t) {
    const double open = 0.5 - 0.5 * wave_cos(phase_of(t, 1.0));
    Pose pose = standing(style);
    for (auto& arm : pose.arm) {
      arm.abduction = 10 + 152 * style.reach * open;
      arm.twist = 90;
      arm.elbow = 6 + style.elbow * (1 - open);
    }
    for (auto& leg : pose.leg) {
      leg.abduction = style.stance + 20 * style.reach * open;
      leg.knee = 10 * (1 - open) * (1 - open);
      leg.flexion = leg.knee / 2;
      leg.ankle = -leg.knee / 2;
    }
    return body::grounded(pose, 0.16 * open * (1 - open));
  };
}

}  // namespace

std::vector<ScriptEntry> everyday_scripts() {
  std::vector<ScriptEntry> scripts;
  {
    ScriptFacts f;
    f.name = "jumping-jacks";
    f.summary = "Xbar <-> Ybar: a symmetric palindrome";
    f.duration = 10;
    f.symmetry = Symmetry::kAlways;
    f.period = 1.0;
    f.turn = 0.5;
    f.reach = 0.5;
    scripts.push_back({f, make_jumping_jacks});
  }
  {
    ScriptFacts f;
    f.name = "empty";
    f.summary = "nobody: the room alone";
    f.duration = 8;
    scripts.push_back({f, nullptr});
  }
  return scripts;
}

}  // namespace choreo::devices::synthetic
