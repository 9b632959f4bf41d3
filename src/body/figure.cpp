// SPDX-License-Identifier: Apache-2.0
#include "body/figure.hpp"

#include <algorithm>
#include <numbers>

#include <Eigen/Geometry>

namespace choreo::body {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d turn_x(double degrees) {
  return Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Vector3d::UnitX()).toRotationMatrix();
}
Matrix3d turn_y(double degrees) {
  return Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Vector3d::UnitY()).toRotationMatrix();
}
Matrix3d turn_z(double degrees) {
  return Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Vector3d::UnitZ()).toRotationMatrix();
}

// Every value with its name, in the one order that all functions of this file share.
template <typename AnyPose, typename Visitor>
void visit(AnyPose& pose, Visitor&& at) {
  at("root_x", pose.root.x());
  at("root_y", pose.root.y());
  at("root_z", pose.root.z());
  at("heading", pose.heading);
  at("trunk_lean", pose.trunk_lean);
  at("trunk_side", pose.trunk_side);
  at("trunk_twist", pose.trunk_twist);
  at("neck_nod", pose.neck_nod);
  at("neck_side", pose.neck_side);
  at("neck_turn", pose.neck_turn);
  for (const auto side : {kLeft, kRight}) {
    const std::string name = side == kLeft ? "left_" : "right_";
    at(name + "arm_abduction", pose.arm[side].abduction);
    at(name + "arm_flexion", pose.arm[side].flexion);
    at(name + "arm_twist", pose.arm[side].twist);
    at(name + "elbow", pose.arm[side].elbow);
    at(name + "leg_abduction", pose.leg[side].abduction);
    at(name + "leg_flexion", pose.leg[side].flexion);
    at(name + "leg_twist", pose.leg[side].twist);
    at(name + "knee", pose.leg[side].knee);
    at(name + "ankle", pose.leg[side].ankle);
  }
}

// The frame whose second column points from `from` to `to` and whose third stays as near to `forward` as it can.
Matrix3d frame_along(const Vector3d& from, const Vector3d& to, const Vector3d& forward) {
  Matrix3d axes;
  const Vector3d y = (to - from).normalized();
  Vector3d x = y.cross(forward);
  if (x.squaredNorm() < 1e-12) x = y.unitOrthogonal();
  axes.col(0) = x.normalized();
  axes.col(1) = y;
  axes.col(2) = axes.col(0).cross(y);
  return axes;
}

Ellipsoid between(std::string_view part, const Vector3d& from, const Vector3d& to, const Vector3d& forward,
                  double thickness) {
  const double half_length = std::max((to - from).norm() / 2, thickness);
  return {part, (from + to) / 2, frame_along(from, to, forward), {thickness, half_length, thickness}};
}

}  // namespace

std::array<double, kPoseValues> pose_values(const Pose& pose) {
  std::array<double, kPoseValues> values{};
  std::size_t i = 0;
  visit(pose, [&](const std::string&, double value) { values[i++] = value; });
  return values;
}

Pose pose_from_values(const std::array<double, kPoseValues>& values) {
  Pose pose;
  std::size_t i = 0;
  visit(pose, [&](const std::string&, double& value) { value = values[i++]; });
  return pose;
}

const std::array<std::string, kPoseValues>& pose_value_names() {
  static const auto kNames = [] {
    std::array<std::string, kPoseValues> names;
    std::size_t i = 0;
    const Pose pose;
    visit(pose, [&](const std::string& name, double) { names[i++] = name; });
    return names;
  }();
  return kNames;
}

Pose mirrored(const Pose& pose) {
  Pose other = pose;
  other.root.x() = -pose.root.x();
  other.heading = -pose.heading;
  other.trunk_side = -pose.trunk_side;
  other.trunk_twist = -pose.trunk_twist;
  other.neck_side = -pose.neck_side;
  other.neck_turn = -pose.neck_turn;
  std::swap(other.arm[kLeft], other.arm[kRight]);
  std::swap(other.leg[kLeft], other.leg[kRight]);
  return other;
}

Pose blended(const Pose& a, const Pose& b, double share) {
  auto values = pose_values(a);
  const auto others = pose_values(b);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = (1 - share) * values[i] + share * others[i];
  return pose_from_values(values);
}

Pose grounded(const Pose& pose, double above) {
  const auto s = skeleton_of(pose);
  const double lowest = std::min({s.heel[kLeft].y(), s.heel[kRight].y(), s.toe[kLeft].y(), s.toe[kRight].y()});
  Pose standing = pose;
  standing.root.y() += above - lowest;
  return standing;
}

Skeleton skeleton_of(const Pose& pose) {
  using namespace vitruvian;
  constexpr double kToeOut = 12;      // degrees, as people stand
  constexpr double kHeelShare = 0.3;  // of the foot behind the ankle
  const Vector3d down = -Vector3d::UnitY();
  Skeleton s;
  s.pelvis = pose.root + Vector3d(0, kHipHeight, 0);
  s.pelvis_axes = turn_y(pose.heading);
  s.waist = s.pelvis + Vector3d(0, kWaistHeight - kHipHeight, 0);
  s.chest_axes = s.pelvis_axes * turn_y(pose.trunk_twist) * turn_z(-pose.trunk_side) * turn_x(pose.trunk_lean);
  s.neck = s.waist + s.chest_axes * Vector3d(0, kNeckPit - kWaistHeight, 0);
  s.head_axes = s.chest_axes * turn_y(pose.neck_turn) * turn_z(-pose.neck_side) * turn_x(pose.neck_nod);
  s.skull = s.neck + s.head_axes * Vector3d(0, 1 - kHeadHeight / 2 - kNeckPit, 0);
  s.crown = s.neck + s.head_axes * Vector3d(0, 1 - kNeckPit, 0);
  for (const auto side : {kLeft, kRight}) {
    const double sign = side == kLeft ? 1 : -1;
    const auto& arm = pose.arm[side];
    const Matrix3d upper_arm =
        s.chest_axes * turn_z(sign * arm.abduction) * turn_x(-arm.flexion) * turn_y(sign * arm.twist);
    s.forearm_axes[side] = upper_arm * turn_x(-arm.elbow);
    s.shoulder[side] = s.waist + s.chest_axes * Vector3d(sign * kShoulderHalf, kShoulderHeight - kWaistHeight, 0);
    s.elbow[side] = s.shoulder[side] + upper_arm * down * kUpperArm;
    s.wrist[side] = s.elbow[side] + s.forearm_axes[side] * down * (kForearm - kHand);
    s.fingertip[side] = s.elbow[side] + s.forearm_axes[side] * down * kForearm;

    const auto& leg = pose.leg[side];
    s.thigh_axes[side] = s.pelvis_axes * turn_z(sign * leg.abduction) * turn_x(-leg.flexion) * turn_y(sign * leg.twist);
    s.shank_axes[side] = s.thigh_axes[side] * turn_x(leg.knee);
    s.foot_axes[side] = s.shank_axes[side] * turn_x(leg.ankle) * turn_y(sign * kToeOut);
    s.hip[side] = s.pelvis + s.pelvis_axes * Vector3d(sign * kHipHalf, 0, 0);
    s.knee[side] = s.hip[side] + s.thigh_axes[side] * down * kThigh;
    s.ankle[side] = s.knee[side] + s.shank_axes[side] * down * kShank;
    s.heel[side] = s.ankle[side] + s.foot_axes[side] * Vector3d(0, -kAnkleHeight, -kHeelShare * kFoot);
    s.toe[side] = s.ankle[side] + s.foot_axes[side] * Vector3d(0, -kAnkleHeight, (1 - kHeelShare) * kFoot);
  }
  return s;
}

BuildScale scale_of(Build build) {
  switch (build) {
    case Build::kSlender:
      return {0.86, 0.88};
    case Build::kMedium:
      return {1.0, 1.0};
    case Build::kStout:
      return {1.28, 1.15};
  }
  return {};
}

std::vector<Ellipsoid> ellipsoids_of(const Pose& pose, Build build) {
  using namespace vitruvian;
  const auto s = skeleton_of(pose);
  const auto scale = scale_of(build);
  const Vector3d forward = s.pelvis_axes.col(2);
  const Vector3d chest_forward = s.chest_axes.col(2);
  constexpr double kSole = 0.02;  // the foot's ellipsoid runs this far above its sole
  std::vector<Ellipsoid> parts;
  parts.push_back({"head", s.skull, s.head_axes, {kFaceWidth / 2, kHeadHeight / 2, kFaceWidth / 2}});
  parts.push_back(
      between("neck", s.neck - s.head_axes.col(1) * 0.02, s.skull - s.head_axes.col(1) * 0.03, chest_forward, 0.028));
  parts.push_back(between("chest", s.waist - s.chest_axes.col(1) * 0.03, s.neck + s.chest_axes.col(1) * 0.02,
                          chest_forward, 0.098 * scale.trunk));
  parts.push_back(between("pelvis", s.pelvis - s.pelvis_axes.col(1) * 0.06, s.waist + s.pelvis_axes.col(1) * 0.06,
                          forward, 0.078 * scale.trunk));
  struct Names {
    std::string_view upper_arm, forearm, thigh, shank, foot;
  };
  static constexpr Names kNames[2] = {{"left_upper_arm", "left_forearm", "left_thigh", "left_shank", "left_foot"},
                                      {"right_upper_arm", "right_forearm", "right_thigh", "right_shank", "right_foot"}};
  for (const auto side : {kLeft, kRight}) {
    const auto& name = kNames[side];
    parts.push_back(between(name.upper_arm, s.shoulder[side], s.elbow[side], chest_forward, 0.028 * scale.limb));
    parts.push_back(between(name.forearm, s.elbow[side], s.fingertip[side], chest_forward, kForearmWidth / 2));
    parts.push_back(between(name.thigh, s.hip[side], s.knee[side], forward, 0.045 * scale.limb));
    parts.push_back(between(name.shank, s.knee[side], s.ankle[side], forward, 0.033 * scale.limb));
    const Vector3d lift = s.foot_axes[side].col(1) * kSole;
    parts.push_back(between(name.foot, s.heel[side] + lift, s.toe[side] + lift, s.foot_axes[side].col(1), kSole));
  }
  return parts;
}

}  // namespace choreo::body
