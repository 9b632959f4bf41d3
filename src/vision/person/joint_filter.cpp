// SPDX-License-Identifier: Apache-2.0
#include "vision/person/joint_filter.hpp"

#include <cassert>
#include <numbers>

namespace choreo::vision {
namespace {

// What a new value counts.
double share(double cutoff_hz, double dt_s) {
  const double turns = 2 * std::numbers::pi * cutoff_hz * dt_s;
  return turns / (turns + 1);
}

}  // namespace

template <int N>
void JointFilter::filter(Low<N>& low, const cv::Vec<double, N>& at, double dt_s, double metre) const {
  constexpr double kOfSpeed = 1;  // Hz.
  low.speed += share(kOfSpeed, dt_s) * ((at - low.at) / dt_s - low.speed);
  const double cutoff = options_.cutoff_hz + options_.hz_per_mps * cv::norm(low.speed) / metre;
  low.at += share(cutoff, dt_s) * (at - low.at);
}

PersonLook JointFilter::next(PersonLook look, double time_s) {
  const bool first = !before_;
  auto& state = first ? before_.emplace(State{}) : *before_;
  const double dt_s = time_s - state.time_s;
  assert(first || dt_s > 0);
  const double pixels = look.pixels_per_metre();
  for (std::size_t k = 0; k < kPersonPoints; ++k) {
    auto& at = look.points[k].at;
    auto& metres = look.metres[k];
    if (first) {
      state.picture[k].at = {at.x, at.y};
      state.space[k].at = metres;
      continue;
    }
    filter(state.picture[k], {at.x, at.y}, dt_s, pixels > 0 ? pixels : 1);
    filter(state.space[k], {metres.x, metres.y, metres.z}, dt_s, 1);
    at = {state.picture[k].at[0], state.picture[k].at[1]};
    metres = state.space[k].at;
  }
  state.time_s = time_s;
  return look;
}

}  // namespace choreo::vision
