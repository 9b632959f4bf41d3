// SPDX-License-Identifier: Apache-2.0
// Of looks that do not agree, the arms that lie where the silhouette shows some.
#include "pipeline/fitted_arms.hpp"

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "pipeline/seen_arms.hpp"

namespace choreo::pipeline {
namespace {

using body::kLeft;
using body::kRight;
using Name = vision::PersonPointName;

const cv::Size kSize(256, 256);

// The signaller's right arm and left arm as positions of semaphore; a torso of 50 pixels.
struct Shown {
  double left, right;
};

cv::Point2d along(double position, double length) {
  const double angle = position * CV_PI / 4;
  return cv::Point2d(-std::sin(angle), std::cos(angle)) * length;
}

const cv::Point2d kRightShoulder(113, 80), kLeftShoulder(143, 80);

// A look that puts the arms at `seen` while the silhouette has those at `truth`.
vision::PersonLook look(Shown truth, Shown seen) {
  vision::PersonLook out;
  const auto put = [&](Name name, cv::Point2d at) { out.points[static_cast<std::size_t>(name)] = {at, 0, 0.9, 1}; };
  put(Name::kRightShoulder, kRightShoulder);
  put(Name::kLeftShoulder, kLeftShoulder);
  put(Name::kRightElbow, kRightShoulder + along(seen.right, 27));
  put(Name::kLeftElbow, kLeftShoulder + along(seen.left, 27));
  put(Name::kRightWrist, kRightShoulder + along(seen.right, 52));
  put(Name::kLeftWrist, kLeftShoulder + along(seen.left, 52));
  put(Name::kRightHip, {118, 130});
  put(Name::kLeftHip, {138, 130});
  put(Name::kRightKnee, {118, 170});
  put(Name::kLeftKnee, {138, 170});
  put(Name::kRightAnkle, {118, 210});
  put(Name::kLeftAnkle, {138, 210});
  out.metres[static_cast<std::size_t>(Name::kNose)] = {0, 0, -0.1};
  out.region = {{127.5, 127.5}, 256, 0};
  out.silhouette = cv::Mat::zeros(kSize, CV_8UC1);
  const auto limb = [&](cv::Point2d a, cv::Point2d b, int width) { cv::line(out.silhouette, a, b, 255, width); };
  cv::rectangle(out.silhouette, cv::Rect(110, 76, 36, 56), 255, cv::FILLED);
  cv::circle(out.silhouette, {128, 60}, 13, 255, cv::FILLED);
  limb({118, 130}, {118, 212}, 14);
  limb({138, 130}, {138, 212}, 14);
  limb(kRightShoulder, kRightShoulder + along(truth.right, 62), 10);
  limb(kLeftShoulder, kLeftShoulder + along(truth.left, 62), 10);
  return out;
}

// The same as a look at the mirror image.
ArmLook flipped(const vision::PersonLook& look) {
  ArmLook out{look, true};
  constexpr std::array kPairs = {
      std::pair(Name::kLeftShoulder, Name::kRightShoulder), std::pair(Name::kLeftElbow, Name::kRightElbow),
      std::pair(Name::kLeftWrist, Name::kRightWrist),       std::pair(Name::kLeftHip, Name::kRightHip),
      std::pair(Name::kLeftKnee, Name::kRightKnee),         std::pair(Name::kLeftAnkle, Name::kRightAnkle)};
  for (const auto& [left, right] : kPairs) {
    std::swap(out.look.points[static_cast<std::size_t>(left)], out.look.points[static_cast<std::size_t>(right)]);
  }
  for (auto& point : out.look.points) point.at.x = kSize.width - 1 - point.at.x;
  out.look.region = look.region.flipped(kSize.width);
  cv::flip(look.silhouette, out.look.silhouette, 1);
  return out;
}

body::ArmPoses poses_of(const std::vector<ArmLook>& looks, bool mirrored = false) {
  return arm_poses(fitted_arms(looks, kSize), kSize, mirrored);
}

void expect(const body::ArmPoses& arms, Shown shown) {
  ASSERT_TRUE(arms[kLeft] && arms[kRight]);
  EXPECT_NEAR(body::turn(arms[kLeft]->fore, 45.0 * shown.left), 0, 3);
  EXPECT_NEAR(body::turn(arms[kRight]->fore, 45.0 * shown.right), 0, 3);
}

TEST(FittedArms, OfLooksThatAgreeAreTheirs) {
  const Shown j{6, 4};
  const auto seen = look(j, j);
  expect(poses_of({{seen, false}}), j);
  const auto both = poses_of({{seen, false}, flipped(seen)});
  expect(both, j);
  EXPECT_NEAR(both[kLeft]->seen, 0.9, 1e-6);
}

// One arm is taken for both: J as two arms level.
TEST(FittedArms, OfLooksThatDoNotAreThoseThatLieWhereLimbsAre) {
  const Shown j{6, 4}, confused{6, 6};
  expect(poses_of({{look(j, confused), false}, flipped(look(j, j))}), j);
  expect(poses_of({{look(j, j), false}, flipped(look(j, confused))}), j);
}

TEST(FittedArms, AreOfWhicheverLookSawEachOfThem) {
  const Shown r{6, 2};
  expect(poses_of({{look(r, {6, 3}), false}, flipped(look(r, {4, 2}))}), r);
}

TEST(FittedArms, AreTurnedTowardsTheLimb) {
  const Shown r{6, 2};
  for (const double off : {-0.4, 0.4}) {
    const auto arms = poses_of({{look(r, {6 + off, 2 + off}), false}});
    EXPECT_LT(std::abs(body::turn(arms[kLeft]->fore, 270)), 9) << "of 18 degrees";
    EXPECT_LT(std::abs(body::turn(arms[kRight]->fore, 90)), 9);
  }
}

TEST(FittedArms, OneInFrontOfTheTrunkStaysWhereItIsSeen) {
  const auto arms = poses_of({{look({0, 0}, {1, 0}), false}});
  EXPECT_NEAR(body::turn(arms[kRight]->fore, 0), 0, 8);
}

TEST(FittedArms, ThoseThatNoLookHasWhereLimbsAreAreDoubtful) {
  const auto arms = poses_of({{look({6, 2}, {5, 3}), false}});
  ASSERT_TRUE(arms[kLeft] && arms[kRight]);
  EXPECT_LT(arms[kLeft]->seen, 0.3);
  EXPECT_LT(arms[kRight]->seen, 0.3);
}

TEST(FittedArms, ArmsThatExplainNothingAreNotSeen) {
  const auto arms = poses_of({{look({0, 0}, {5, 3}), false}});
  ASSERT_TRUE(arms[kLeft] && arms[kRight]);
  EXPECT_LT(arms[kLeft]->seen, 0.1);
  EXPECT_LT(arms[kRight]->seen, 0.1);
}

TEST(FittedArms, OfAMirrorImageAreTheOtherSides) {
  // The picture of somebody who shows J, mirrored: the network takes the right arm for the left one.
  const Shown j{6, 4}, mirror{4, 2};
  const Shown confused{2, 2};
  expect(poses_of({{look(mirror, confused), false}, flipped(look(mirror, mirror))}, true), j);
}

TEST(FittedArms, WithoutASilhouetteAreThoseOfTheFirstLook) {
  auto seen = look({6, 4}, {6, 4});
  seen.silhouette.release();
  expect(poses_of({{seen, false}}), {6, 4});
}

}  // namespace
}  // namespace choreo::pipeline
