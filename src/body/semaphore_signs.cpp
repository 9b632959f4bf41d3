// SPDX-License-Identifier: Apache-2.0
#include "body/semaphore_signs.hpp"

#include <algorithm>
#include <array>
#include <cassert>

namespace choreo::body {
namespace {

// Name, left arm, right arm. Mirror partners of the table mirror each other arm by arm.
constexpr std::array<SemaphoreSign, 29> kSigns = {{
    {"A", 0, 1}, {"B", 0, 2}, {"C", 0, 3},    {"D", 0, 4},        {"E", 5, 0},      {"F", 6, 0},
    {"G", 7, 0}, {"H", 1, 2}, {"I", 1, 3},    {"J", 6, 4},        {"K", 4, 1},      {"L", 5, 1},
    {"M", 6, 1}, {"N", 7, 1}, {"O", 3, 2},    {"P", 4, 2},        {"Q", 5, 2},      {"R", 6, 2},
    {"S", 7, 2}, {"T", 4, 3}, {"U", 5, 3},    {"V", 7, 4},        {"W", 6, 5},      {"X", 5, 7},
    {"Y", 6, 3}, {"Z", 6, 7}, {"REST", 0, 0}, {"NUMERALS", 5, 4}, {"CANCEL", 7, 3},
}};

// Degrees of abduction that bring an arm to a position; beyond the body's middle the arm reaches across, in front.
ArmAngles arm_at(int position, Side side) {
  // In steps towards the arm's own side: 0 down, 2 horizontal, 4 up.
  const int own = side == kLeft ? mirrored_position(position) : position;
  ArmAngles arm;
  if (own == 0) {
    arm.abduction = 4;
  } else if (own <= 4) {
    arm.abduction = own * 45.0;
  } else {
    arm.abduction = (own - 8) * 45.0;
    arm.flexion = 15;
  }
  return arm;
}

}  // namespace

std::span<const SemaphoreSign> semaphore_signs() { return kSigns; }

std::size_t place_of(std::string_view name) {
  const auto found = std::ranges::find(kSigns, name, &SemaphoreSign::name);
  assert(found != kSigns.end());
  return std::size_t(found - kSigns.begin());
}

std::optional<SemaphoreSign> semaphore(std::string_view name) {
  const auto found = std::ranges::find(kSigns, name, &SemaphoreSign::name);
  if (found == kSigns.end()) return std::nullopt;
  return *found;
}

std::optional<SemaphoreSign> semaphore_at(int one_arm, int other_arm) {
  const auto found = std::find_if(kSigns.begin(), kSigns.end(), [&](const auto& s) {
    return (s.left == one_arm && s.right == other_arm) || (s.left == other_arm && s.right == one_arm);
  });
  if (found == kSigns.end()) return std::nullopt;
  return *found;
}

Pose semaphore_pose(const SemaphoreSign& sign) {
  Pose pose;
  pose.arm[kLeft] = arm_at(sign.left, kLeft);
  pose.arm[kRight] = arm_at(sign.right, kRight);
  for (auto& leg : pose.leg) leg.abduction = 3;
  return grounded(pose);
}

}  // namespace choreo::body
