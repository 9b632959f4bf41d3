// SPDX-License-Identifier: Apache-2.0
#include "pipeline/seen_arms.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace choreo::pipeline {
namespace {

using body::ArmPose;
using body::ArmPoses;
using body::kLeft;
using body::kRight;
using body::Side;
using body::whole_turns_off;
using vision::PersonLook;
using Name = vision::PersonPointName;

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kMostLean = 30;

// From straight down towards the left of the picture, which is the signaller's right.
double direction(cv::Point2d v) { return whole_turns_off(std::atan2(-v.x, v.y) * kDegrees); }

double lean_of(const PersonLook& look) {
  const auto across = look[Name::kLeftShoulder].at - look[Name::kRightShoulder].at;
  // Who turns away shows the left shoulder on the left.
  return std::clamp(std::atan2(across.y, std::abs(across.x)) * kDegrees, -kMostLean, kMostLean);
}

double torso_of(const PersonLook& look) {
  const auto shoulders = look[Name::kLeftShoulder].at + look[Name::kRightShoulder].at;
  const auto hips = look[Name::kLeftHip].at + look[Name::kRightHip].at;
  return cv::norm(shoulders - hips) / 2;
}

}  // namespace

ArmPoses arm_poses(const PersonLook& look, cv::Size picture, bool mirrored) {
  struct Joints {
    Side side;
    Name shoulder, elbow, wrist;
  };
  constexpr std::array kArms = {Joints{kLeft, Name::kLeftShoulder, Name::kLeftElbow, Name::kLeftWrist},
                                Joints{kRight, Name::kRightShoulder, Name::kRightElbow, Name::kRightWrist}};
  // From behind the signaller's right is on the right, and what is shown is shown to somebody else.
  if (look.faces_away()) return {};
  const double torso = torso_of(look);
  const double lean = lean_of(look) / 2;
  ArmPoses out;
  for (const auto& arm : kArms) {
    const auto upper = look[arm.elbow].at - look[arm.shoulder].at;
    const auto fore = look[arm.wrist].at - look[arm.elbow].at;
    if (torso <= 0 || cv::norm(upper) <= 0 || cv::norm(fore) <= 0) continue;
    const auto& wrist = look[arm.wrist];
    const bool inside = cv::Rect2d(-0.5, -0.5, picture.width, picture.height).contains(wrist.at);
    ArmPose pose;
    pose.upper = whole_turns_off(direction(upper) - lean);
    pose.fore = whole_turns_off(direction(fore) - lean);
    pose.length = (cv::norm(upper) + cv::norm(fore)) / torso;
    pose.seen = inside ? wrist.visibility : 0;
    Side side = arm.side;
    if (mirrored) {
      side = side == kLeft ? kRight : kLeft;
      pose.upper = whole_turns_off(-pose.upper);
      pose.fore = whole_turns_off(-pose.fore);
    }
    out[side] = pose;
  }
  return out;
}

}  // namespace choreo::pipeline
