// SPDX-License-Identifier: Apache-2.0
// The figure's proportions, axes and mirror images, and the semaphore alphabet.
#include "body/figure.hpp"

#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <string_view>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "body/semaphore_signs.hpp"

namespace choreo::body {
namespace {

using Eigen::Vector3d;

// A pose in which every value differs from its mirror partner's.
Pose crooked_pose() {
  std::array<double, kPoseValues> values{};
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = 3.0 + 5.0 * static_cast<double>(i % 7) - 0.9 * static_cast<double>(i);
  values[0] = 0.11;
  values[1] = 0.02;
  values[2] = -0.07;
  return pose_from_values(values);
}

TEST(Figure, StandingItIsOneHighWithItsSolesOnTheFloor) {
  const auto s = skeleton_of(Pose{});
  EXPECT_NEAR(s.crown.y(), 1.0, 1e-12);
  EXPECT_NEAR(s.toe[kLeft].y(), 0.0, 1e-12);
  EXPECT_NEAR(s.heel[kRight].y(), 0.0, 1e-12);
  EXPECT_NEAR(s.pelvis.y(), 0.52, 1e-12);
  EXPECT_NEAR(s.knee[kLeft].y(), 0.27, 1e-12);
  // The top of the breast lies a sixth below the hairline, and the hairline a tenth above the chin at 7/8.
  EXPECT_NEAR(s.neck.y(), 0.875 + 0.1 - 1.0 / 6, 1e-12);
}

TEST(Figure, WithArmsOutItIsAsWideAsHigh) {
  Pose pose;
  for (auto& arm : pose.arm) arm.abduction = 90;
  const auto s = skeleton_of(pose);
  EXPECT_NEAR(s.fingertip[kLeft].x(), 0.5, 1e-12);
  EXPECT_NEAR(s.fingertip[kRight].x(), -0.5, 1e-12);
  EXPECT_NEAR(s.elbow[kLeft].x(), 0.25, 1e-12);
  EXPECT_NEAR(s.wrist[kLeft].x(), 0.4, 1e-12);
  EXPECT_NEAR(s.fingertip[kLeft].y(), s.shoulder[kLeft].y(), 1e-12);
}

TEST(Figure, TheFootIsASixthOfTheHeight) {
  const auto s = skeleton_of(Pose{});
  EXPECT_NEAR((s.toe[kLeft] - s.heel[kLeft]).norm(), 1.0 / 6, 1e-12);
  EXPECT_GT(s.toe[kLeft].z(), s.heel[kLeft].z());
  EXPECT_GT(s.toe[kLeft].x(), s.heel[kLeft].x());  // toes out
}

// The part of that name; nothing where there is none.
std::optional<Ellipsoid> part_of(Build build, std::string_view name) {
  for (const auto& part : ellipsoids_of(Pose{}, build)) {
    if (part.part == name) return part;
  }
  return std::nullopt;
}

TEST(Figure, HeadAndForearmHaveTheCanonsSizes) {
  const auto head = part_of(Build::kMedium, "head");
  ASSERT_TRUE(head);
  EXPECT_NEAR(2 * head->half.x(), 1.0 / 10, 1e-12);
  EXPECT_NEAR(2 * head->half.y(), 1.0 / 8, 1e-12);
  EXPECT_NEAR(head->centre.y(), 1 - 1.0 / 16, 1e-12);
  const auto forearm = part_of(Build::kMedium, "left_forearm");
  ASSERT_TRUE(forearm);
  EXPECT_NEAR(2 * forearm->half.y(), 1.0 / 4, 1e-12);
  EXPECT_NEAR(2 * forearm->half.x(), 1.0 / 20, 1e-12);
}

TEST(Figure, EllipsoidsAreProlateAndOrthonormalInAnyPose) {
  const auto parts = ellipsoids_of(crooked_pose(), Build::kStout);
  ASSERT_EQ(parts.size(), 14u);
  std::set<std::string_view> names;
  for (const auto& part : parts) {
    names.insert(part.part);
    EXPECT_EQ(part.half.x(), part.half.z()) << part.part;
    EXPECT_LE(part.half.x(), part.half.y()) << part.part;
    EXPECT_LT((part.axes.transpose() * part.axes - Eigen::Matrix3d::Identity()).norm(), 1e-12) << part.part;
    EXPECT_NEAR(part.axes.determinant(), 1, 1e-12) << part.part;
  }
  EXPECT_EQ(names.size(), 14u);
}

TEST(Figure, BuildsChangeThicknessAndNotLength) {
  const auto slender = ellipsoids_of(Pose{}, Build::kSlender);
  const auto stout = ellipsoids_of(Pose{}, Build::kStout);
  ASSERT_EQ(slender.size(), 14u);
  ASSERT_EQ(stout.size(), slender.size());
  for (std::size_t i = 0; i < slender.size(); ++i) {
    EXPECT_EQ(slender[i].half.y(), stout[i].half.y()) << slender[i].part;
    EXPECT_EQ(slender[i].centre, stout[i].centre) << slender[i].part;
  }
  EXPECT_LT(part_of(Build::kSlender, "left_thigh").value().half.x(),
            part_of(Build::kStout, "left_thigh").value().half.x());
  EXPECT_EQ(part_of(Build::kSlender, "head").value().half, part_of(Build::kStout, "head").value().half);
}

TEST(Figure, TheShouldersAxesAreAsDocumented) {
  const auto hand_from_shoulder = [](const ArmAngles& left) {
    Pose pose;
    pose.arm[kLeft] = left;
    const auto s = skeleton_of(pose);
    return Vector3d(s.fingertip[kLeft] - s.shoulder[kLeft]);
  };
  EXPECT_LT((hand_from_shoulder({0, 0, 0, 0}) - Vector3d(0, -0.375, 0)).norm(), 1e-12);
  EXPECT_LT((hand_from_shoulder({180, 0, 0, 0}) - Vector3d(0, 0.375, 0)).norm(), 1e-12);
  EXPECT_LT((hand_from_shoulder({0, 90, 0, 0}) - Vector3d(0, 0, 0.375)).norm(), 1e-12);
  // Elbow at right angles: forward, outwards, inwards; and upwards of an arm held out sideways.
  EXPECT_LT((hand_from_shoulder({0, 0, 0, 90}) - Vector3d(0, -0.125, 0.25)).norm(), 1e-12);
  EXPECT_LT((hand_from_shoulder({0, 0, 90, 90}) - Vector3d(0.25, -0.125, 0)).norm(), 1e-12);
  EXPECT_LT((hand_from_shoulder({0, 0, -90, 90}) - Vector3d(-0.25, -0.125, 0)).norm(), 1e-12);
  EXPECT_LT((hand_from_shoulder({90, 0, 90, 90}) - Vector3d(0.125, 0.25, 0)).norm(), 1e-12);
}

TEST(Figure, FlexionLeavesTheArmsAngleInThePicture) {
  Pose pose;
  pose.arm[kLeft] = {-45, 15, 0, 0};
  const auto s = skeleton_of(pose);
  const Vector3d arm = s.elbow[kLeft] - s.shoulder[kLeft];
  EXPECT_NEAR(arm.x(), arm.y(), 1e-12);  // down and across, both by as much
  EXPECT_GT(arm.z(), 0.03);              // and in front of the body
}

TEST(Figure, TheLegsAxesAreAsDocumented) {
  Pose pose;
  pose.leg[kLeft] = {0, 90, 0, 90, 0};
  auto s = skeleton_of(pose);
  EXPECT_LT((s.knee[kLeft] - s.hip[kLeft] - Vector3d(0, 0, 0.25)).norm(), 1e-12);
  EXPECT_LT((s.ankle[kLeft] - s.knee[kLeft] - Vector3d(0, -0.23, 0)).norm(), 1e-12);
  pose.leg[kLeft] = {90, 0, 0, 0, 0};
  s = skeleton_of(pose);
  EXPECT_LT((s.knee[kLeft] - s.hip[kLeft] - Vector3d(0.25, 0, 0)).norm(), 1e-12);
}

TEST(Figure, TrunkAndHeadingTurnTheDocumentedWay) {
  Pose pose;
  pose.trunk_side = 30;
  EXPECT_GT(skeleton_of(pose).crown.x(), 0.15);
  pose = {};
  pose.trunk_lean = 30;
  EXPECT_GT(skeleton_of(pose).crown.z(), 0.15);
  pose = {};
  pose.heading = 90;
  EXPECT_GT(skeleton_of(pose).toe[kRight].x(), 0.05);
  pose = {};
  pose.trunk_twist = 90;
  EXPECT_NEAR(skeleton_of(pose).shoulder[kRight].z(), 0.125, 1e-12);
}

TEST(Figure, MirroringTwiceGivesTheSamePose) {
  const auto pose = crooked_pose();
  EXPECT_EQ(pose_values(mirrored(mirrored(pose))), pose_values(pose));
  EXPECT_NE(pose_values(mirrored(pose)), pose_values(pose));
}

TEST(Figure, TheMirroredPoseHasEveryJointOnTheOtherSideOfTheMirror) {
  const auto s = skeleton_of(crooked_pose());
  const auto m = skeleton_of(mirrored(crooked_pose()));
  const auto reflected = [](const Vector3d& p) { return Vector3d(-p.x(), p.y(), p.z()); };
  EXPECT_LT((m.crown - reflected(s.crown)).norm(), 1e-12);
  EXPECT_LT((m.neck - reflected(s.neck)).norm(), 1e-12);
  for (const auto side : {kLeft, kRight}) {
    const auto other = side == kLeft ? kRight : kLeft;
    EXPECT_LT((m.elbow[side] - reflected(s.elbow[other])).norm(), 1e-12);
    EXPECT_LT((m.fingertip[side] - reflected(s.fingertip[other])).norm(), 1e-12);
    EXPECT_LT((m.ankle[side] - reflected(s.ankle[other])).norm(), 1e-12);
    EXPECT_LT((m.toe[side] - reflected(s.toe[other])).norm(), 1e-12);
  }
}

TEST(Figure, ValuesHaveDistinctNamesAndGoInAndOutUnchanged) {
  const auto& names = pose_value_names();
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), kPoseValues);
  EXPECT_EQ(names[3], "heading");
  const auto values = pose_values(crooked_pose());
  EXPECT_EQ(pose_values(pose_from_values(values)), values);
}

TEST(Figure, GroundingPutsTheLowestSoleOnTheFloor) {
  Pose pose;
  pose.leg[kLeft] = {20, 60, 10, 80, 10};
  pose.leg[kRight] = {-5, 25, 0, 50, -25};
  for (const double above : {0.0, 0.07}) {
    const auto s = skeleton_of(grounded(pose, above));
    EXPECT_NEAR(std::min({s.heel[kLeft].y(), s.toe[kLeft].y(), s.heel[kRight].y(), s.toe[kRight].y()}), above, 1e-12);
  }
}

TEST(Figure, BlendingGoesStraightFromOneToTheOther) {
  Pose a, b;
  a.arm[kLeft].abduction = 10;
  b.arm[kLeft].abduction = 50;
  b.root.x() = 0.2;
  const auto quarter = blended(a, b, 0.25);
  EXPECT_DOUBLE_EQ(quarter.arm[kLeft].abduction, 20);
  EXPECT_DOUBLE_EQ(quarter.root.x(), 0.05);
}

int position_of(const SemaphoreSign& sign, Side side) { return side == kLeft ? sign.left : sign.right; }

TEST(Semaphore, TheTableIsTheAlphabetOfArmPositions) {
  // Groups of the manual: the lesser position, the letters in order, the first greater position.
  struct Circle {
    int lesser;
    std::vector<std::string_view> names;
    int first;
  };
  const std::vector<Circle> circles = {{0, {"A", "B", "C", "D", "E", "F", "G"}, 1},
                                       {1, {"H", "I", "K", "L", "M", "N"}, 2},
                                       {2, {"O", "P", "Q", "R", "S"}, 3},
                                       {3, {"T", "U", "Y", "CANCEL"}, 4},
                                       {4, {"NUMERALS", "J", "V"}, 5},
                                       {5, {"W", "X"}, 6},
                                       {6, {"Z"}, 7},
                                       {0, {"REST"}, 0}};
  std::size_t count = 0;
  for (const auto& circle : circles) {
    int greater = circle.first;
    for (const auto name : circle.names) {
      const auto sign = semaphore(name);
      ASSERT_TRUE(sign) << name;
      EXPECT_EQ(std::min(sign->left, sign->right), circle.lesser) << name;
      EXPECT_EQ(std::max(sign->left, sign->right), greater) << name;
      ASSERT_TRUE(semaphore_at(greater, circle.lesser)) << name;
      EXPECT_EQ(semaphore_at(greater, circle.lesser)->name, name);
      ++greater;
      ++count;
    }
  }
  EXPECT_EQ(count, 29u);
  EXPECT_EQ(semaphore_signs().size(), 29u);
  EXPECT_FALSE(semaphore("a"));
  EXPECT_FALSE(semaphore_at(1, 1));
}

TEST(Semaphore, MirrorPartnersMirrorEachOtherArmByArm) {
  const std::vector<std::pair<std::string_view, std::string_view>> partners = {
      {"A", "G"}, {"B", "F"}, {"C", "E"},      {"H", "Z"},        {"I", "X"}, {"K", "V"}, {"M", "S"}, {"O", "W"},
      {"P", "J"}, {"Q", "Y"}, {"L", "CANCEL"}, {"T", "NUMERALS"}, {"N", "N"}, {"R", "R"}, {"U", "U"}, {"REST", "REST"}};
  for (const auto& [one, other] : partners) {
    const auto a = semaphore(one).value();
    const auto b = semaphore(other).value();
    EXPECT_EQ(mirrored_position(a.left), b.right) << one;
    EXPECT_EQ(mirrored_position(a.right), b.left) << one;
    EXPECT_EQ(pose_values(mirrored(semaphore_pose(a))), pose_values(semaphore_pose(b))) << one;
  }
  // D shows the same two positions in the mirror, with the arms exchanged.
  const auto d = semaphore("D").value();
  EXPECT_EQ(semaphore_at(mirrored_position(d.left), mirrored_position(d.right))->name, "D");
}

TEST(Semaphore, ArmsPointWhereTheSignSays) {
  for (const auto& sign : semaphore_signs()) {
    const auto s = skeleton_of(semaphore_pose(sign));
    for (const auto side : {kLeft, kRight}) {
      const int position = position_of(sign, side);
      const Vector3d arm = s.fingertip[side] - s.shoulder[side];
      // Position k points k * 45 degrees from down towards the signaller's right, which is -x.
      const double wanted = position * std::numbers::pi / 4;
      const double cosine = (arm.x() * -std::sin(wanted) + arm.y() * -std::cos(wanted)) / std::hypot(arm.x(), arm.y());
      EXPECT_GT(cosine, std::cos(5 * std::numbers::pi / 180)) << sign.name << " side " << side;
    }
  }
}

}  // namespace
}  // namespace choreo::body
