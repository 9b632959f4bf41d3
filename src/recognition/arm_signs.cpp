// SPDX-License-Identifier: Apache-2.0
#include "recognition/arm_signs.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "body/semaphore_signs.hpp"

namespace choreo::recognition {
namespace {

constexpr std::size_t kPositions = 8;
constexpr double kAim = 11;      // Degrees, of a signaller's forearm.
constexpr double kHangs = 7;     // Degrees outwards, of an arm that hangs beside its hip.
constexpr double kBend = 18;     // Degrees, of an upper arm off the middle between its forearm and the position;
constexpr double kAcross = 40;   // of one that reaches across the body, towards the camera.
constexpr double kBends = 300;   // Degrees, all bends there are.
constexpr double kShort = 0.55;  // Torsos, of an arm of which it is doubtful whether it lies in the picture's plane.
constexpr double kAcrossShort = 0.85;  // Of that, where it reaches across.
constexpr double kShortness = 0.06;
constexpr double kHardlySeen = 0.15;

double normal(double x, double deviation) {
  return std::exp(-x * x / (2 * deviation * deviation)) / (deviation * std::sqrt(2 * std::numbers::pi));
}

// How many times likelier the arm is where it is shown than by chance, at each position.
std::array<double, kPositions> odds_of(const body::ArmPose& arm, body::Side side) {
  const double seen = arm.seen / (arm.seen + kHardlySeen);
  std::array<double, kPositions> odds{};
  for (std::size_t k = 0; k < kPositions; ++k) {
    const bool across = side == body::kLeft ? k > 0 && k < 4 : k > 4;
    const double outwards = k > 0 ? 0 : side == body::kLeft ? -kHangs : kHangs;
    const double off = body::turn(45.0 * double(k) + outwards, arm.fore);
    const double bent = body::turn(arm.fore - off / 2, arm.upper);
    const double straight = normal(bent, across ? kAcross : kBend) * kBends;
    const double shortest = across ? kShort * kAcrossShort : kShort;
    const double in_plane = 1 / (1 + std::exp((shortest - arm.length) / kShortness));
    odds[k] = normal(off, std::hypot(kAim, arm.spread)) * 360 * straight * in_plane * seen;
  }
  return odds;
}

// On the same side of the body, up and down aside.
bool to_one_side(int a, int b) { return (a % 4 != 0) && (b % 4 != 0) && (a < 4) == (b < 4); }

}  // namespace

ArmSigns arm_signs(const body::ArmPoses& arms) {
  constexpr double kLeastSeen = 0.1;
  const auto& signs = body::semaphore_signs();
  ArmSigns out;
  out.best = signs[1].name;
  out.next = signs[0].name;
  const auto hidden = [](const auto& arm) { return !arm || arm->seen < kLeastSeen; };
  if (hidden(arms[body::kLeft]) || hidden(arms[body::kRight])) {
    out.arms_hidden = true;
    return out;
  }
  const auto left = odds_of(*arms[body::kLeft], body::kLeft);
  const auto right = odds_of(*arms[body::kRight], body::kRight);
  double all = 1, best = -1, next = -1, rest = 0;
  for (std::size_t i = 0; i < signs.size(); ++i) {
    const auto& sign = signs[i];
    const auto l = std::size_t(sign.left), r = std::size_t(sign.right);
    double odds = left[l] * right[r];
    if (to_one_side(sign.left, sign.right)) odds = (odds + left[r] * right[l]) / 2;
    odds /= double(signs.size());
    all += odds;
    out.of[i] = odds;
    if (sign.name == "REST") {
      rest = odds;
    } else if (odds > best) {
      next = best;
      out.next = out.best;
      best = odds;
      out.best = sign.name;
    } else if (odds > next) {
      next = odds;
      out.next = sign.name;
    }
  }
  out.probability = best / all;
  out.rest = rest / all;
  out.none = 1 / all;
  for (double& p : out.of) p /= all;
  return out;
}

}  // namespace choreo::recognition
