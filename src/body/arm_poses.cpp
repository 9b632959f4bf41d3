// SPDX-License-Identifier: Apache-2.0
#include "body/arm_poses.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace choreo::body {

double whole_turns_off(double degrees) {
  const double rest = std::fmod(degrees, 360);
  return rest < 0 ? rest + 360 : rest;
}

double turn(double from, double to) { return whole_turns_off(to - from + 180) - 180; }

ArmPoses mean_of(std::span<const ArmPoses> looks) {
  assert(!looks.empty());
  ArmPoses out = looks.front();
  for (const auto side : {kLeft, kRight}) {
    if (!std::ranges::all_of(looks, [&](const auto& look) { return look[side].has_value(); })) {
      out[side].reset();
      continue;
    }
    // About the first, from which they are not far.
    const auto first = *looks.front()[side];
    double upper = 0, fore = 0, square = 0;
    ArmPose sum = {0, 0, 0, 0, 0};
    for (const auto& look : looks) {
      const auto& pose = *look[side];
      upper += turn(first.upper, pose.upper);
      const double away = turn(first.fore, pose.fore);
      fore += away;
      square += away * away;
      sum.length += pose.length;
      sum.seen += pose.seen;
    }
    const auto n = double(looks.size());
    out[side] = {whole_turns_off(first.upper + upper / n), whole_turns_off(first.fore + fore / n), sum.length / n,
                 sum.seen / n, std::sqrt(std::max(0.0, square / n - fore * fore / n / n))};
  }
  return out;
}

}  // namespace choreo::body
