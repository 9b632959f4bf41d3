// SPDX-License-Identifier: Apache-2.0
// Joints that were seen become directions, and one picture's arms its letter.
#include "pipeline/seen_arms.hpp"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "pipeline/picture_reading.hpp"
#include "vision/tiny_pose.hpp"

namespace choreo::pipeline {
namespace {

using body::kLeft;
using body::kRight;
using Name = vision::PersonPointName;

const cv::Size kSize(400, 300);

// Faces the camera: the right arm level, the left one straight up; a torso of 100 pixels.
vision::PersonLook somebody() {
  vision::PersonLook look;
  const auto put = [&](Name name, double x, double y) {
    look.points[static_cast<std::size_t>(name)] = {{x, y}, 0, 0.9, 1};
  };
  put(Name::kRightShoulder, 175, 100);
  put(Name::kRightElbow, 125, 100);
  put(Name::kRightWrist, 80, 100);
  put(Name::kLeftShoulder, 225, 100);
  put(Name::kLeftElbow, 225, 50);
  put(Name::kLeftWrist, 225, 5);
  put(Name::kRightHip, 185, 200);
  put(Name::kLeftHip, 215, 200);
  look.metres[static_cast<std::size_t>(Name::kNose)] = {0, 0, -0.1};  // Towards the camera.
  return look;
}

TEST(SeenArms, OfWhoFacesAwayNothingIsTold) {
  auto look = somebody();
  EXPECT_TRUE(arm_poses(look, kSize)[kLeft]);
  look.metres[static_cast<std::size_t>(Name::kNose)].z = 0.1;
  const auto away = arm_poses(look, kSize);
  EXPECT_FALSE(away[kLeft] || away[kRight]);
}

TEST(SeenArms, AreCountedAsSemaphoreCountsThem) {
  const auto arms = arm_poses(somebody(), kSize);
  ASSERT_TRUE(arms[kRight] && arms[kLeft]);
  EXPECT_NEAR(arms[kRight]->fore, 90, 1e-9);
  EXPECT_NEAR(arms[kRight]->upper, 90, 1e-9);
  EXPECT_NEAR(arms[kRight]->length, 0.95, 1e-9);
  EXPECT_NEAR(arms[kRight]->seen, 0.9, 1e-9);
  EXPECT_NEAR(arms[kLeft]->fore, 180, 1e-9);
}

TEST(SeenArms, OfAMirrorImageAreTheOtherSides) {
  const auto arms = arm_poses(somebody(), kSize, true);
  EXPECT_NEAR(arms[kLeft]->fore, 270, 1e-9);
  EXPECT_NEAR(arms[kRight]->fore, 180, 1e-9);
}

TEST(SeenArms, ShouldersThatLeanTurnThemByHalfOfThat) {
  auto look = somebody();
  for (auto& point : look.points) {
    const auto p = point.at - cv::Point2d(200, 100);
    const double a = 0.2;
    point.at = cv::Point2d(200, 100) +
               cv::Point2d(std::cos(a) * p.x - std::sin(a) * p.y, std::sin(a) * p.x + std::cos(a) * p.y);
  }
  const double degrees = 0.2 * 180 / CV_PI;
  EXPECT_NEAR(arm_poses(look, kSize)[kRight]->fore, 90 + degrees / 2, 1e-6);
}

TEST(SeenArms, AHandBeyondThePictureIsNotSeenAndAnArmWithoutLengthIsNone) {
  auto look = somebody();
  look.points[static_cast<std::size_t>(Name::kLeftWrist)].at = {225, -3};
  look.points[static_cast<std::size_t>(Name::kRightWrist)].at = look[Name::kRightElbow].at;
  const auto arms = arm_poses(look, kSize);
  EXPECT_EQ(arms[kLeft]->seen, 0);
  EXPECT_FALSE(arms[kRight]);
}

TEST(ReadByNetwork, SaysWhyItReadsNothing) {
  auto people = test::tiny_search();
  cv::Mat picture(224, 224, CV_8UC3, cv::Scalar());
  const auto nobody = read_by_network(picture, people, false);
  EXPECT_EQ(nobody.why, NoSign::kNobody);
  EXPECT_EQ(nobody.confidence, 0);
  picture(cv::Rect(100, 100, 24, 24)).setTo(cv::Scalar::all(255));
  const auto hidden = read_by_network(picture, people, false);  // Of this person one wrist is.
  EXPECT_EQ(hidden.why, NoSign::kHidden);
  EXPECT_FALSE(hidden.sign);
  EXPECT_EQ(hidden.evidence.size(), picture.size());
  // Neither the whole picture nor its ends show this one; a smaller part does.
  cv::Mat wide(224, 672, CV_8UC3, cv::Scalar());
  wide(cv::Rect(196, 105, 14, 14)).setTo(cv::Scalar::all(255));
  EXPECT_FALSE(people.search(wide, {}));
  EXPECT_EQ(read_by_network(wide, people, false).why, NoSign::kHidden);
}

}  // namespace
}  // namespace choreo::pipeline
