// SPDX-License-Identifier: Apache-2.0
// Two arms as somebody holds them, and the sign they show.
#include "recognition/arm_signs.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "body/semaphore_signs.hpp"

namespace choreo::recognition {
namespace {

using body::ArmPose;
using body::ArmPoses;

ArmPose straight(double degrees) { return {degrees, degrees, 1, 1, 0}; }
ArmPoses arms(ArmPose left, ArmPose right) { return {left, right}; }
// Arms that hang do so beside the hips.
ArmPoses showing(const body::SemaphoreSign& sign, double off = 0) {
  const auto points = [](int position, double outwards) { return position == 0 ? outwards : 45.0 * position; };
  return arms(straight(points(sign.left, 353) + off), straight(points(sign.right, 7) - off));
}

TEST(ArmSigns, EverySignIsReadThoughBothForearmsAreTwelveDegreesOff) {
  for (const auto& sign : body::semaphore_signs()) {
    for (const double off : {-12.0, 0.0, 12.0}) {
      const auto read = arm_signs(showing(sign, off));
      if (sign.name == "REST") {
        EXPECT_GT(read.rest, 0.8) << off;
        EXPECT_LT(read.probability, 0.1) << off;
      } else {
        EXPECT_EQ(read.best, sign.name) << off;
        // An arm that reaches across may be bent more, and tells less.
        const bool across = (sign.left > 0 && sign.left < 4) || sign.right > 4;
        EXPECT_GT(read.probability, across ? 0.7 : 0.8) << sign.name << off;
        EXPECT_NE(read.next, sign.name);
        EXPECT_NE(read.next, "REST");
      }
      double all = read.rest + read.none + read.probability;
      EXPECT_LE(all, 1 + 1e-9);
    }
  }
}

TEST(ArmSigns, TheForearmDecidesWhereAnElbowIsBentALittle) {
  ArmPose right = straight(45);
  right.upper = 8;
  right.fore = 37;
  EXPECT_EQ(arm_signs(arms(straight(0), right)).best, "A");
  EXPECT_GT(arm_signs(arms(straight(0), right)).probability, 0.7);
}

// The upper arm points at the camera: short and hardly anywhere.
TEST(ArmSigns, AnArmThatReachesAcrossMayBeBentFurther) {
  const ArmPose right = straight(90);
  const auto left = [](double bend) { return ArmPose{135 + bend, 135, 0.57, 0.98, 0}; };
  EXPECT_EQ(arm_signs(arms(left(60), right)).best, "O");
  EXPECT_GT(arm_signs(arms(left(60), right)).probability, 0.6);
  EXPECT_LT(arm_signs(arms(left(120), right)).probability, 0.5);
  // One that keeps to its own side may not: Q.
  EXPECT_LT(arm_signs(arms({225 + 75, 225, 0.57, 0.98, 0}, right)).probability, 0.5);
}

TEST(ArmSigns, BetweenTwoDirectionsItIsNeitherForSure) {
  const auto read = arm_signs(arms(straight(0), straight(67.5)));
  EXPECT_TRUE((read.best == "A" && read.next == "B") || (read.best == "B" && read.next == "A"));
  EXPECT_LT(read.probability, 0.5);
}

TEST(ArmSigns, WhatLooksDoNotAgreeOnIsLessSure) {
  auto unsure = showing(*body::semaphore("R"), 12);
  const double sure = arm_signs(unsure).probability;
  unsure[body::kLeft]->spread = 25;
  EXPECT_LT(arm_signs(unsure).probability, sure);
}

// Hands on the hips, at the head, folded, as telephones are held.
TEST(ArmSigns, ElbowsThatAreBentShowNone) {
  for (const double bend : {-130.0, -90.0, -75.0, 75.0, 90.0, 130.0}) {
    for (double upper = 0; upper < 360; upper += 15) {
      ArmPose right = straight(upper);
      right.fore = body::whole_turns_off(upper + bend);
      ArmPose left = straight(body::whole_turns_off(-upper));
      left.fore = body::whole_turns_off(-right.fore);
      EXPECT_LT(arm_signs(arms(left, right)).probability, 0.5) << upper << " bent by " << bend;
    }
  }
}

TEST(ArmSigns, AnArmThatPointsAtTheCameraShowsNone) {
  auto read = showing(*body::semaphore("R"));
  read[body::kRight]->length = 0.2;
  EXPECT_LT(arm_signs(read).probability, 0.5);
}

TEST(ArmSigns, OfAnArmThatIsHiddenNothingCanBeTold) {
  auto read = showing(*body::semaphore("R"));
  EXPECT_FALSE(arm_signs(read).arms_hidden);
  read[body::kRight]->seen = 0;
  EXPECT_TRUE(arm_signs(read).arms_hidden);
  EXPECT_EQ(arm_signs(read).probability, 0);
  read[body::kRight].reset();
  EXPECT_TRUE(arm_signs(read).arms_hidden);
}

TEST(ArmSigns, EitherArmReachesAcrossAndNeitherCrossesTheOther) {
  const auto h = *body::semaphore("H");
  EXPECT_EQ(arm_signs(arms(straight(45 * h.right), straight(45 * h.left))).best, "H");
  EXPECT_GT(arm_signs(arms(straight(45 * h.right), straight(45 * h.left))).probability, 0.9);
  // Hands folded before the belly, not N.
  EXPECT_LT(arm_signs(arms(straight(45), straight(315))).probability, 0.5);
}

TEST(ArmPoses, TheMeanOfDirectionsKnowsNoJumpAtTheTurn) {
  const std::vector<ArmPoses> looks = {arms(straight(350), straight(90)), arms(straight(10), straight(100))};
  const auto mean = body::mean_of(looks);
  EXPECT_NEAR(std::abs(body::turn(mean[body::kLeft]->fore, 0)), 0, 1e-9);
  EXPECT_NEAR(mean[body::kLeft]->spread, 10, 1e-9);
  EXPECT_NEAR(mean[body::kRight]->fore, 95, 1e-9);
  EXPECT_NEAR(mean[body::kRight]->spread, 5, 1e-9);
  const std::vector<ArmPoses> one_lacks = {looks[0], {straight(0), std::nullopt}};
  EXPECT_FALSE(body::mean_of(one_lacks)[body::kRight]);
}

TEST(ArmPoses, ATurnIsTheShorterWay) {
  EXPECT_EQ(body::turn(350, 10), 20);
  EXPECT_EQ(body::turn(10, 350), -20);
  EXPECT_EQ(body::turn(0, 180), -180);
  EXPECT_EQ(body::whole_turns_off(-90), 270);
}

}  // namespace
}  // namespace choreo::recognition
