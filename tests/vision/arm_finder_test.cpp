// SPDX-License-Identifier: Apache-2.0
// Every named case of the arms, drawn in face widths; then the figure's 29 signs.
#include "vision/arm_finder.hpp"

#include <functional>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "body/semaphore_signs.hpp"
#include "core/error.hpp"
#include "support/arm_pictures.hpp"

namespace choreo::vision {
namespace {

constexpr double kUnit = 30;  // A face width in pixels.
const cv::Size kArmsSize(480, 420);
const cv::Point2d kFace(240, 130);
const cv::Mat kEverywhere;

// A person drawn in face widths from the face's centre, y down.
class Drawing {
 public:
  Drawing() : tone(cv::Mat::zeros(kArmsSize, CV_8UC1)) {
    face.centre = kFace;
    face.width = kUnit;
    face.confidence = 1;
    cv::ellipse(tone, kFace, {int(0.5 * kUnit), int(0.65 * kUnit)}, 0, 0, 360, cv::Scalar(255), -1);
    limb({0, 0.4}, {0, 1}, 0.5);
  }
  Drawing(const Drawing& other) : tone(other.tone.clone()), face(other.face) {}
  Drawing& limb(cv::Point2d from, cv::Point2d to, double width = 0.5, int value = 255) {
    cv::line(tone, (kFace + kUnit * from) * 256, (kFace + kUnit * to) * 256, cv::Scalar(value),
             int(std::lround(width * kUnit)), cv::LINE_8, 8);
    return *this;
  }
  // Sleeve, watch or strap.
  Drawing& covered(cv::Point2d from, cv::Point2d to) {
    cv::rectangle(tone, kFace + kUnit * from, kFace + kUnit * to, cv::Scalar(0), -1);
    return *this;
  }
  [[nodiscard]] Arms found(ArmFinder& finder, double time_s = 0) const {
    return finder.find(tone, kEverywhere, face, time_s);
  }
  [[nodiscard]] Arms found() const {
    ArmFinder finder;
    return found(finder);
  }

  cv::Mat tone;
  TrackedFace face;
};

// The middle of an arm, in face widths.
void expect_at(const Blob& blob, cv::Point2d place, double tolerance = 0.05) {
  const auto found = (blob.moments.centroid - kFace) * (1 / kUnit);
  EXPECT_NEAR(found.x, place.x, tolerance);
  EXPECT_NEAR(found.y, place.y, tolerance);
}

Drawing out_to_both_sides() { return Drawing().limb({-2.5, 1.3}, {-5, 1.3}).limb({2.5, 1.3}, {5, 1.3}); }

TEST(ArmFinder, TwoForearmsAreTwoArmsTheLeftOneFirst) {
  const auto arms = out_to_both_sides().found();
  ASSERT_EQ(arms.found, ArmCase::kTwoArms);
  EXPECT_FALSE(arms.at_face);
  EXPECT_FALSE(arms.pieced);
  expect_at(arms.blob[0], {-3.75, 1.3});
  expect_at(arms.blob[1], {3.75, 1.3});
  EXPECT_LT(arms.blob[0].box.x, arms.blob[1].box.x);
}

TEST(ArmFinder, WithoutAFaceNothingIsSaid) {
  ArmFinder finder;
  const auto arms = finder.find(out_to_both_sides().tone, kEverywhere, std::nullopt, 0);
  EXPECT_EQ(arms.found, ArmCase::kNoFace);
  EXPECT_EQ(arms.blob[0].moments.m00, 0);
}

TEST(ArmFinder, AFaceAloneHasNoArm) {
  const auto arms = Drawing().found();
  EXPECT_EQ(arms.found, ArmCase::kNoArm);
  EXPECT_FALSE(arms.at_face);
  EXPECT_EQ(arms.blob[0].moments.m00, 0);
}

TEST(ArmFinder, WhereNothingIsSkinThereIsNoArm) {
  auto drawing = Drawing();
  drawing.tone.setTo(0);
  EXPECT_EQ(drawing.found().found, ArmCase::kNoArm);
}

TEST(ArmFinder, WhereEverythingIsSkinThereIsNoArm) {
  auto drawing = Drawing();
  drawing.tone.setTo(255);
  EXPECT_EQ(drawing.found().found, ArmCase::kNoArm);
  // Nor in a body that is all skin.
  ArmFinder finder;
  const auto person = test::arm_picture({}, {});
  EXPECT_EQ(finder.find(person.body, person.body, person.face, 0).found, ArmCase::kNoArm);
}

TEST(ArmFinder, OneArmAloneIsOneArm) {
  const auto arms = Drawing().limb({2.5, 1.3}, {5, 1.3}).found();
  EXPECT_EQ(arms.found, ArmCase::kOneArm);
  expect_at(arms.blob[0], {3.75, 1.3});
  EXPECT_EQ(arms.blob[1].moments.m00, 0);
}

TEST(ArmFinder, AWholeBareArmAloneIsOneArm) {
  EXPECT_EQ(Drawing().limb({1.25, 1.3}, {5, 1.3}).found().found, ArmCase::kOneArm);
}

TEST(ArmFinder, HandsThatMeetJoinTheArms) {
  const auto arms = Drawing().limb({-1.3, 2.5}, {0, 4.6}).limb({1.3, 2.5}, {0, 4.6}).found();
  EXPECT_EQ(arms.found, ArmCase::kJoined);
  EXPECT_NEAR((arms.blob[0].moments.centroid.x - kFace.x) / kUnit, 0, 0.05);
  EXPECT_EQ(arms.blob[1].moments.m00, 0);
}

TEST(ArmFinder, HandsThatMeetOverTheHeadJoinTheArms) {
  EXPECT_EQ(Drawing().limb({-2, 0}, {0, -2.1}).limb({2, 0}, {0, -2.1}).found().found, ArmCase::kJoined);
}

TEST(ArmFinder, ArmsThatCrossJoin) {
  EXPECT_EQ(Drawing().limb({-1.3, 2.3}, {0.8, 3.4}).limb({1.3, 2.3}, {-0.8, 3.4}).found().found, ArmCase::kJoined);
  EXPECT_EQ(Drawing().limb({-1.2, 2}, {1.1, 2}).limb({1.2, 2.4}, {-1.1, 2.4}).found().found, ArmCase::kJoined);
}

TEST(ArmFinder, BareUpperArmsThatJoinAcrossTheChestAreToldApart) {
  auto drawing = Drawing().limb({-5, 1.3}, {5, 1.3});
  drawing.limb({0, 1}, {0, 1.8}, 0.8);
  const auto arms = drawing.found();
  ASSERT_EQ(arms.found, ArmCase::kTwoArms);
  expect_at(arms.blob[0], {-3.0, 1.3}, 0.15);
  expect_at(arms.blob[1], {3.0, 1.3}, 0.15);
}

TEST(ArmFinder, BareArmsThatJoinAcrossTheChestAndAtTheHandsAreJoined) {
  const auto arms =
      Drawing().limb({-1.5, 1.3}, {1.5, 1.3}).limb({-1.5, 1.3}, {0, 4.6}).limb({1.5, 1.3}, {0, 4.6}).found();
  EXPECT_EQ(arms.found, ArmCase::kJoined);
}

TEST(ArmFinder, ANecklineIsNoArm) {
  const auto drawing = Drawing().limb({0, 1}, {0, 2}, 0.6).limb({2.5, 1.3}, {5, 1.3});
  EXPECT_EQ(drawing.found().found, ArmCase::kOneArm);
}

TEST(ArmFinder, BareLegsAreNoArms) {
  const auto legs = [](Drawing d) { return d.limb({-0.6, 5}, {-0.7, 8.6}, 0.7).limb({0.6, 5}, {0.7, 8.6}, 0.7); };
  EXPECT_EQ(legs(Drawing()).found().found, ArmCase::kNoArm);
  const auto arms = legs(out_to_both_sides()).found();
  ASSERT_EQ(arms.found, ArmCase::kTwoArms);
  expect_at(arms.blob[0], {-3.75, 1.3});
  expect_at(arms.blob[1], {3.75, 1.3});
}

TEST(ArmFinder, ARaisedArmThatTouchesTheCheekDoesNotJoinTheFace) {
  const auto arms = Drawing().limb({0.85, 0.9}, {0.85, -1.8}).limb({-2.5, 1.3}, {-5, 1.3}).found();
  ASSERT_EQ(arms.found, ArmCase::kTwoArms);
  EXPECT_TRUE(arms.at_face);
  expect_at(arms.blob[1], {0.85, -0.5}, 0.3);
}

TEST(ArmFinder, AHandBeforeTheFaceLeavesTheForearm) {
  const auto arms = Drawing().limb({1.8, 2.2}, {0.1, 0.1}).limb({-2.5, 1.3}, {-5, 1.3}).found();
  ASSERT_EQ(arms.found, ArmCase::kTwoArms);
  EXPECT_TRUE(arms.at_face);
  EXPECT_GT(arms.blob[1].moments.centroid.x, kFace.x + kUnit);
  EXPECT_GT(arms.blob[1].moments.centroid.y, kFace.y + kUnit);
}

TEST(ArmFinder, AnArmAcrossTheFaceIsPutTogether) {
  const auto arms = Drawing().limb({1.25, 1.2}, {-1.2, -1.2}).limb({-2.5, 1.3}, {-5, 1.3}).found();
  ASSERT_EQ(arms.found, ArmCase::kTwoArms);
  EXPECT_TRUE(arms.at_face);
  EXPECT_TRUE(arms.pieced);
  expect_at(arms.blob[1], {0, 0}, 0.3);
}

TEST(ArmFinder, AWatchOrASleeveSplitsAnArmThatIsPutTogether) {
  const auto whole = out_to_both_sides().found();
  for (const auto& [from, to] : {std::pair{4.2, 4.4}, std::pair{3.0, 3.6}}) {
    const auto arms = out_to_both_sides().covered({from, 0.9}, {to, 1.7}).found();
    ASSERT_EQ(arms.found, ArmCase::kTwoArms);
    EXPECT_TRUE(arms.pieced);
    expect_at(arms.blob[0], {-3.75, 1.3});
    expect_at(arms.blob[1], {3.75, 1.3}, 0.15);
    EXPECT_EQ(arms.blob[1].box, whole.blob[1].box);
  }
}

TEST(ArmFinder, TheMomentsOfPiecesAdd) {
  const auto drawing = out_to_both_sides().covered({4.2, 0.9}, {4.4, 1.7});
  const auto arms = drawing.found();
  const auto right = moments_of(drawing.tone(cv::Rect(300, 0, 180, 420)));
  EXPECT_EQ(arms.blob[1].moments.m00, right.m00);
  EXPECT_NEAR(arms.blob[1].moments.centroid.x, right.centroid.x + 300, 1e-9);
  EXPECT_NEAR(arms.blob[1].moments.mu20, right.mu20, 1e-6);
  EXPECT_NEAR(arms.blob[1].moments.mu30, right.mu30, 1e-3);
}

TEST(ArmFinder, ASleeveOverTheElbowSplitsABentArmThatIsPutTogether) {
  auto drawing = Drawing().limb({2.5, 1.3}, {5, 1.3});
  drawing.limb({-1.6, 1.6}, {-2, 2.3}).limb({-2, 3.2}, {-1.8, 5});
  const auto arms = drawing.found();
  ASSERT_EQ(arms.found, ArmCase::kTwoArms);
  EXPECT_TRUE(arms.pieced);
  EXPECT_GT(arms.blob[0].box.height, 3.2 * kUnit);
}

TEST(ArmFinder, TwoForearmsSideBySideAreTwoArmsNotPieces) {
  const auto arms = Drawing().limb({1.0, 2.6}, {1.0, 5}).limb({1.9, 2.6}, {1.9, 5}).found();
  EXPECT_EQ(arms.found, ArmCase::kTwoArms);
  EXPECT_FALSE(arms.pieced);
}

TEST(ArmFinder, FingertipsThatNearlyMeetAreTwoArmsNotPieces) {
  const auto arms = Drawing().limb({-2.6, 2.6}, {-0.4, 2.6}).limb({2.6, 2.6}, {0.4, 2.6}).found();
  EXPECT_EQ(arms.found, ArmCase::kTwoArms);
  EXPECT_FALSE(arms.pieced);
}

TEST(ArmFinder, WhatIsNotBodyIsNoArm) {
  auto drawing = Drawing().limb({2.5, 1.3}, {5, 1.3});
  drawing.limb({-2.5, 1.3}, {-5, 1.3});
  cv::Mat body(kArmsSize, CV_8UC1, cv::Scalar(255));
  body(cv::Rect(0, 0, 200, 420)).setTo(0);
  ArmFinder finder;
  const auto arms = finder.find(drawing.tone, body, drawing.face, 0);
  EXPECT_EQ(arms.found, ArmCase::kOneArm);
  expect_at(arms.blob[0], {3.75, 1.3});
}

TEST(ArmFinder, LessProbableThanAskedIsNotTheTone) {
  auto drawing = Drawing().limb({-2.5, 1.3}, {-5, 1.3}, 0.5, 150).limb({2.5, 1.3}, {5, 1.3}, 0.5, 220);
  EXPECT_EQ(drawing.found().found, ArmCase::kTwoArms);
  ArmFinder strict({.min_probability = 0.8});
  EXPECT_EQ(drawing.found(strict).found, ArmCase::kOneArm);
}

TEST(ArmFinder, NoiseIsNeitherArmNorPiece) {
  auto drawing = out_to_both_sides();
  cv::RNG random(7);
  for (int k = 0; k < 300; ++k) drawing.tone.at<uchar>(random.uniform(0, 420), random.uniform(0, 480)) = 255;
  const auto arms = drawing.found();
  ASSERT_EQ(arms.found, ArmCase::kTwoArms);
  expect_at(arms.blob[0], {-3.75, 1.3}, 0.1);
  expect_at(arms.blob[1], {3.75, 1.3}, 0.1);
}

TEST(ArmFinder, ContinuityChoosesBetweenAlikeRegions) {
  // A third region as large as an arm; the two that were arms before stay arms.
  const auto two = Drawing().limb({-2.5, 1.3}, {-4.5, 1.3}).limb({2.5, 1.3}, {4.5, 1.3});
  const auto three = Drawing(two).limb({-1.2, 4}, {1.2, 4}, 0.55);
  ArmFinder finder;
  ASSERT_EQ(two.found(finder, 0).found, ArmCase::kTwoArms);
  const auto arms = three.found(finder, 0.03);
  expect_at(arms.blob[0], {-3.5, 1.3});
  expect_at(arms.blob[1], {3.5, 1.3});
}

TEST(ArmFinder, LearnsHowLargeArmsAreByTimeAndNotByFrames) {
  const auto wide = Drawing().limb({-2.2, 1.3}, {-5, 1.3}, 0.8).limb({2.2, 1.3}, {5, 1.3}, 0.8);
  std::vector<double> learned;
  for (const double fps : {10.0, 30.0, 120.0}) {
    ArmFinder finder;
    for (int f = 0; f <= fps / 2; ++f) ASSERT_EQ(wide.found(finder, f / fps).found, ArmCase::kTwoArms);
    learned.push_back(finder.typical_arm());
  }
  EXPECT_GT(learned[1], ArmOptions{}.typical_arm + 0.3);
  EXPECT_NEAR(learned[0], learned[1], 1e-6);
  EXPECT_NEAR(learned[2], learned[1], 1e-6);
}

TEST(ArmFinder, AtTheRightEdgeOfTheWidestPictureThereAreArmsToo) {
  const auto drawing = out_to_both_sides();
  const auto here = drawing.found();
  const cv::Point shift(kLongestSide - kArmsSize.width, kLongestSide - kArmsSize.height);
  cv::Mat wide = cv::Mat::zeros(kLongestSide, kLongestSide, CV_8UC1);
  drawing.tone.copyTo(wide(cv::Rect(shift, kArmsSize)));
  auto face = drawing.face;
  face.centre += cv::Point2d(shift);
  ArmFinder finder;
  const auto there = finder.find(wide, kEverywhere, face, 0);
  ASSERT_EQ(there.found, ArmCase::kTwoArms);
  for (std::size_t k = 0; k < 2; ++k) EXPECT_EQ(there.blob[k].box, here.blob[k].box + shift);
}

TEST(ArmFinder, ShortForearmsTowardsTheCameraThatMeetAreJoinedBecauseTwoWereThere) {
  const auto apart = Drawing().limb({-1, 3}, {-1, 3.9}, 0.6).limb({1, 3}, {1, 3.9}, 0.6);
  const auto meeting =
      Drawing().limb({-0.5, 3}, {-0.5, 3.9}, 0.8).limb({0.5, 3}, {0.5, 3.9}, 0.8).limb({-0.5, 3.4}, {0.5, 3.4}, 0.8);
  ArmFinder finder;
  ASSERT_EQ(apart.found(finder, 0).found, ArmCase::kTwoArms);
  EXPECT_EQ(meeting.found(finder, 0.03).found, ArmCase::kJoined);
}

TEST(ArmFinder, APictureAtItsEdgesAndAFaceOutsideAreNoTrouble) {
  for (const auto& at : {cv::Point2d(0, 0), cv::Point2d(479, 419), cv::Point2d(-300, 50), cv::Point2d(1e6, 1e6)}) {
    for (const double width : {0.5, 30.0, 2000.0}) {
      auto drawing = out_to_both_sides();
      drawing.face.centre = at;
      drawing.face.width = width;
      const auto arms = drawing.found();
      EXPECT_NE(arms.found, ArmCase::kNoFace);
    }
  }
}

TEST(ArmFinder, WhereInThePictureTheBodyStandsDoesNotMatter) {
  auto drawing = Drawing().limb({-1.5, 2}, {-3, 3.4}).limb({1.5, 1.3}, {3.6, 0.2});
  const auto here = drawing.found();
  cv::Mat moved = cv::Mat::zeros(kArmsSize, CV_8UC1);
  drawing.tone(cv::Rect(0, 0, 440, 400)).copyTo(moved(cv::Rect(31, 17, 440, 400)));
  drawing.tone = moved;
  drawing.face.centre += cv::Point2d(31, 17);
  const auto there = drawing.found();
  ASSERT_EQ(here.found, ArmCase::kTwoArms);
  ASSERT_EQ(there.found, ArmCase::kTwoArms);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(there.blob[k].moments.mu20, here.blob[k].moments.mu20);
    EXPECT_NEAR(there.blob[k].moments.centroid.x - here.blob[k].moments.centroid.x, 31, 1e-9);
    EXPECT_EQ(there.blob[k].box, here.blob[k].box + cv::Point(31, 17));
  }
}

TEST(ArmFinder, FindsTheArmsOfAllSignsWhateverTheSleeve) {
  for (const double bare_from : {0.0, 0.5, 1.0}) {
    double sum = 0;
    int count = 0;
    for (const auto& sign : body::semaphore_signs()) {
      const auto p = test::arm_picture(body::semaphore_pose(sign), {.bare_from = bare_from});
      ArmFinder finder;
      const auto arms = finder.find(p.tone, p.body, p.face, 0);
      ASSERT_EQ(arms.found, ArmCase::kTwoArms) << sign.name << " bare from " << bare_from;
      auto truth = std::array{moments_of(p.arm[0]).centroid, moments_of(p.arm[1]).centroid};
      if (truth[1].x < truth[0].x) std::swap(truth[0], truth[1]);
      for (std::size_t k = 0; k < 2; ++k) {
        const double error = cv::norm(arms.blob[k].moments.centroid - truth[k]) / p.face.width;
        EXPECT_LT(error, 0.9) << sign.name << " bare from " << bare_from;  // O and W reach across the face.
        sum += error;
        ++count;
      }
    }
    EXPECT_LT(sum / count, 0.05) << "bare from " << bare_from;
  }
}

TEST(ArmOptions, AreRefusedByName) {
  EXPECT_NO_THROW(ArmOptions{}.validate());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  using Change = std::function<void(ArmOptions&)>;
  const std::vector<std::pair<const char*, Change>> wrong = {
      {"arms.min_probability", [](auto& o) { o.min_probability = 0; }},
      {"arms.min_probability", [](auto& o) { o.min_probability = 1.01; }},
      {"arms.anneal", [](auto& o) { o.anneal = -1; }},
      {"arms.reach", [=](auto& o) { o.reach = nan; }},
      {"arms.shoulder_aside", [](auto& o) { o.shoulder_aside = 9; }},
      {"arms.shoulder_below", [](auto& o) { o.shoulder_below = -1; }},
      {"arms.typical_arm", [](auto& o) { o.typical_arm = 0; }},
      {"arms.least_arm", [](auto& o) { o.least_arm = 0; }},
      {"arms.largest_arm", [](auto& o) { o.largest_arm = 0.1; }},
      {"arms.least_piece", [](auto& o) { o.least_piece = 0.3; }},
      {"arms.piece_gap", [](auto& o) { o.piece_gap = 4; }},
      {"arms.memory_s", [](auto& o) { o.memory_s = 11; }},
  };
  for (const auto& [where, change] : wrong) {
    ArmOptions options;
    change(options);
    try {
      ArmFinder finder(options);
      ADD_FAILURE() << where;
    } catch (const Error& e) {
      EXPECT_EQ(e.where(), where);
      EXPECT_EQ(e.fault(), Fault::kUsage);
    }
  }
}

}  // namespace
}  // namespace choreo::vision
