// SPDX-License-Identifier: Apache-2.0
// What the synthetic performer says of its face, its bare arms, its flags and its signs.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "devices/synthetic/mannequin.hpp"
#include "devices/synthetic/synthetic_source.hpp"
#include "support/performers.hpp"

namespace choreo::devices {
namespace {

using body::kLeft;
using body::kRight;
using Eigen::Vector3d;
using synthetic::Performer;
using test::performer_of;

synthetic::Performance held(const std::string& sign, const std::string& settings = "") {
  return performer_of("semaphore?empty=0&noise=0&text=" + sign + "&" + settings).perform(60);
}

cv::Point2d seen(const synthetic::Stage& stage, const Vector3d& p) {
  return {stage.centre_x + stage.unit * p.x(), stage.floor_y - stage.unit * p.y()};
}

TEST(SyntheticSleeves, EndAtWristOrElbowOrLeaveTheWholeArmBare) {
  const auto stage = synthetic::make_stage({640, 480});
  const auto first_bare = [&](const std::string& sleeves) {
    const auto frame = held("R", "sleeves=" + sleeves);
    const auto s = body::skeleton_of(frame.pose);
    // How far from the shoulder the arm begins to be bare, in units of H.
    const auto box = cv::boundingRect(frame.bare_arm[kLeft]);
    return (box.x - seen(stage, s.shoulder[kLeft]).x) / stage.unit;
  };
  using namespace body::vitruvian;
  EXPECT_NEAR(first_bare("half"), kUpperArm, 0.01);
  EXPECT_NEAR(first_bare("long"), kUpperArm + kForearm - kHand, 0.02);
  EXPECT_LT(first_bare("none"), 0.01);
  EXPECT_EQ(first_bare("half"), [&] {
    const auto frame = held("R");
    return (cv::boundingRect(frame.bare_arm[kLeft]).x - seen(stage, body::skeleton_of(frame.pose).shoulder[kLeft]).x) /
           stage.unit;
  }()) << "the default";
}

TEST(SyntheticSleeves, WhatIsBareHasTheSkinsColourAllAlong) {
  for (const auto* skin : {"very-light", "tan", "dark"}) {
    const auto performer = performer_of(std::string("semaphore?text=R&empty=0&noise=0&sleeves=none&skin=") + skin);
    const auto frame = performer.perform(60);
    const auto& own = performer.look().skin;
    for (const auto side : {kLeft, kRight}) {
      cv::Mat inside;
      cv::erode(frame.bare_arm[side], inside, cv::Mat());
      const auto box = cv::boundingRect(inside);
      // Shoulder to hand in six parts: every one has the skin's proportions of colours, in some light.
      for (int part = 0; part < 6; ++part) {
        const cv::Rect where(box.x + part * box.width / 6, box.y, box.width / 6, box.height);
        const auto mean = cv::mean(frame.bgr(where), inside(where));
        EXPECT_NEAR(mean[2] / mean[1], own[2] / own[1], 0.02 * own[2] / own[1]) << skin << " " << part;
        EXPECT_NEAR(mean[0] / mean[1], own[0] / own[1], 0.02) << skin << " " << part;
        EXPECT_GT(mean[1], 0.75 * own[1]) << skin << " " << part;
      }
    }
  }
}

TEST(SyntheticTruth, EachArmsSkinIsItsOwnAndWhatIsHiddenIsNotSeen) {
  const auto apart = held("R", "sleeves=none");
  EXPECT_EQ(cv::countNonZero(apart.bare_arm[kLeft] & apart.bare_arm[kRight]), 0);
  EXPECT_GT(cv::boundingRect(apart.bare_arm[kLeft]).x, 320);
  EXPECT_LT(cv::boundingRect(apart.bare_arm[kRight]).br().x, 320);
  for (const auto& arm : apart.bare_arm) EXPECT_EQ(cv::countNonZero(arm & (apart.mask == 0)), 0);
  // Facing the picture's right edge, the left arm hangs behind the trunk.
  const auto stage = synthetic::make_stage({320, 240});
  const auto look = synthetic::choose_look(1, "stout", "light", "auto");
  body::Pose aside;
  aside.heading = 90;
  synthetic::Brush brush;
  ASSERT_TRUE(synthetic::draw_figure(brush, aside, look, stage, {0, 0}));
  std::array<int, 2> samples{};
  for (int y = brush.box().y; y < brush.box().br().y; ++y) {
    for (int x = brush.box().x; x < brush.box().br().x; ++x) {
      for (const auto side : {kLeft, kRight}) samples[side] += brush.marked(x, y, synthetic::kBareArmMark[side]);
    }
  }
  EXPECT_GT(samples[kRight], 1000);
  EXPECT_LT(samples[kLeft], samples[kRight] / 2);
}

TEST(SyntheticTruth, TheFaceIsFromCheekToCheekAndFromChinToHairline) {
  const auto face = held("R").face;
  // Vitruvius: a tenth of the height each; H is 360 pixels here. The chin is an eighth below the crown.
  EXPECT_NEAR(face.width, 36, 1.5);
  EXPECT_NEAR(face.height, 36, 1.5);
  EXPECT_NEAR(face.x + face.width / 2, 320, 0.01);
  EXPECT_NEAR(face.br().y, 456 - 360 * (1 - 0.125), 1.5);
  EXPECT_TRUE(performer_of("empty?noise=0").perform(3).face.empty());
}

TEST(SyntheticTruth, AFaceThatIsTurnedAwayOrCoveredOrOutsideIsNone) {
  const auto stage = synthetic::make_stage({640, 480});
  const auto look = synthetic::choose_look(1, "medium", "light", "auto");
  const auto face_of = [&](const body::Pose& pose, const synthetic::Stage& where) {
    synthetic::Brush brush;
    if (!synthetic::draw_figure(brush, pose, look, where, {0, 0})) return cv::Rect2d();
    return synthetic::visible_face(brush, pose, where, {0, 0});
  };
  body::Pose pose;
  const auto front = face_of(pose, stage);
  pose.neck_turn = 60;
  const auto turned = face_of(pose, stage);
  EXPECT_GT(turned.x + turned.width / 2, front.x + front.width / 2) << "to the performer's left";
  EXPECT_NEAR(turned.width, front.width * (1 + std::cos(std::numbers::pi / 3)) / 2, 1e-6);
  pose.neck_turn = 20;
  pose.heading = 120;
  EXPECT_TRUE(face_of(pose, stage).empty());

  // Both arms crossed before the face.
  pose = body::Pose();
  for (auto& arm : pose.arm) arm = {-140, 15, 0, 0};
  const auto covered = face_of(pose, stage);
  pose.arm = {};
  EXPECT_FALSE(face_of(pose, stage).empty());
  EXPECT_TRUE(covered.empty());

  auto outside = stage;
  outside.floor_y = 360 * (1 - 0.09);  // two thirds of the face are above the picture
  EXPECT_TRUE(face_of(pose, outside).empty());
}

TEST(SyntheticTruth, SaysWhichSignIsHeldAndNothingInBetween) {
  const auto performer = performer_of("semaphore?text=A^B&empty=1&rate=12&noise=0&size=64x48");
  const auto sign_at = [&](double seconds) { return performer.perform(static_cast<int>(seconds * 30)).sign; };
  EXPECT_EQ(sign_at(0.5), "");
  EXPECT_EQ(sign_at(1.5), "") << "rising";
  EXPECT_EQ(sign_at(2), "A");
  EXPECT_EQ(sign_at(4.4), "A");
  EXPECT_EQ(sign_at(4.8), "");
  EXPECT_EQ(sign_at(8), "ATTENTION");
  EXPECT_EQ(performer_of("idle?size=64x48").perform(60).sign, "");
}

TEST(SyntheticFlags, AreSquaresOfASixthInBothHandsWhichTheyHide) {
  for (const auto* sign : {"R", "U", "N"}) {
    const auto with = held(sign, "flags=1&distance=1.2&skin=medium&clothes=blue");
    const auto without = held(sign, "distance=1.2&skin=medium&clothes=blue");
    const double side = 360 / 1.2 / 6;
    cv::Mat changed;
    cv::absdiff(with.bgr, without.bgr, changed);
    cv::cvtColor(changed, changed, cv::COLOR_BGR2GRAY);
    EXPECT_NEAR(cv::countNonZero(changed > 8), 2 * side * side, 0.12 * side * side) << sign;
    int red = 0, yellow = 0;
    for (int y = 0; y < 480; ++y) {
      for (int x = 0; x < 640; ++x) {
        const auto p = with.bgr.at<cv::Vec3b>(y, x);
        red += p[2] > 160 && p[1] < 60;
        yellow += p[2] > 200 && p[1] > 170 && p[0] < 60;
      }
    }
    EXPECT_NEAR(red, side * side, 0.15 * side * side) << sign;
    EXPECT_NEAR(yellow, side * side, 0.15 * side * side) << sign;
    const auto stage = synthetic::moved_stage(synthetic::make_stage({640, 480}), 1.2, 0);
    const auto s = body::skeleton_of(with.pose);
    for (const auto arm : {kLeft, kRight}) {
      const cv::Point hand = seen(stage, (s.wrist[arm] + s.fingertip[arm]) / 2);
      EXPECT_EQ(with.bare_arm[arm].at<unsigned char>(hand), 0) << sign;
      EXPECT_EQ(without.bare_arm[arm].at<unsigned char>(hand), 255) << sign;
      EXPECT_EQ(with.mask.at<unsigned char>(hand), 255) << sign;
    }
  }
}

}  // namespace
}  // namespace choreo::devices
