// SPDX-License-Identifier: Apache-2.0
// Which pixels of a depth picture are body: holes, the projector's shadow, unknown rooms, planes, and rooms that
// change.
#include "vision/depth_masker.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "support/frames.hpp"

namespace choreo::vision {
namespace {

using test::error_of;
using test::same_pixels;

const cv::Size kDepthSize{80, 60};
const cv::Rect kNearBody{30, 15, 20, 30};

cv::Mat depth_room(int z = 3000) { return {kDepthSize, CV_16UC1, cv::Scalar(z)}; }

cv::Mat with_body(int z = 2000, const cv::Mat& before = depth_room()) {
  cv::Mat depth = before.clone();
  depth(kNearBody) = z;
  return depth;
}

DepthBackground known(const cv::Mat& depth, float spread_mm = 5) {
  DepthBackground background;
  background.depth_mm = depth.clone();
  background.spread_mm = cv::Mat(depth.size(), CV_32FC1, cv::Scalar(spread_mm));
  background.noise_per_mm = 5e-7;
  return background;
}

MaskOptions mask_options() {
  MaskOptions options;
  options.steps = 0;
  return options;
}

cv::Mat mask_of(const cv::Mat& depth, const cv::Mat& before = depth_room(), const DepthOptions& options = {},
                const MaskOptions& mask = mask_options()) {
  DepthMasker masker(known(before), options, mask);
  return masker.process(depth, 0).body;
}

cv::Mat filled(cv::Rect where) {
  cv::Mat mask = cv::Mat::zeros(kDepthSize, CV_8UC1);
  mask(where) = 255;
  return mask;
}

/// A rectangle whose corners the vote of 3 x 3 takes.
cv::Mat rounded(cv::Rect where) {
  auto mask = filled(where);
  for (const int x : {where.x, where.br().x - 1}) {
    for (const int y : {where.y, where.br().y - 1}) mask.at<uchar>(y, x) = 0;
  }
  return mask;
}

TEST(DepthMasker, BodyIsWhatIsNearerThanTheRoomByMoreThanTheMargin) {
  EXPECT_TRUE(same_pixels(mask_of(with_body()), rounded(kNearBody)));
  EXPECT_EQ(cv::countNonZero(mask_of(depth_room())), 0);
  // Spread 5 mm: the margin is the least one, 25 mm.
  EXPECT_EQ(cv::countNonZero(mask_of(with_body(2975))), 0);
  EXPECT_TRUE(same_pixels(mask_of(with_body(2974)), rounded(kNearBody)));
  EXPECT_EQ(cv::countNonZero(mask_of(with_body(3500))), 0) << "what is farther is no body";
  DepthOptions options;
  options.threshold_mm = 400;
  EXPECT_EQ(cv::countNonZero(mask_of(with_body(2600), depth_room(), options)), 0);
  EXPECT_TRUE(same_pixels(mask_of(with_body(2599), depth_room(), options), rounded(kNearBody)));
}

TEST(DepthMasker, WhereReadingsSpreadMoreABodyMustStandOutMore) {
  DepthMasker masker(known(depth_room(), 50), {}, mask_options());
  EXPECT_EQ(cv::countNonZero(masker.process(with_body(2801), 0).body), 0) << "four times 50 mm";
  EXPECT_TRUE(same_pixels(masker.process(with_body(2799), 1).body, rounded(kNearBody)));
}

TEST(DepthMasker, TheSameSceneFartherAwayGivesTheSameMask) {
  for (const int farther : {0, 500, 3000}) {
    EXPECT_TRUE(same_pixels(mask_of(with_body(2000 + farther, depth_room(3000 + farther)), depth_room(3000 + farther)),
                            rounded(kNearBody)));
  }
}

TEST(DepthMasker, AMirroredPictureGivesTheMirroredMask) {
  auto depth = with_body();
  depth(cv::Rect(25, 15, 5, 30)) = 0;
  depth(cv::Rect(35, 20, 1, 3)) = 0;
  cv::Mat flipped, back;
  cv::flip(depth, flipped, 1);
  cv::flip(mask_of(flipped), back, 1);
  EXPECT_TRUE(same_pixels(back, mask_of(depth)));
}

TEST(DepthMasker, TheShadowBesideABodyIsNoBodyOnEitherSide) {
  for (const cv::Rect shadow : {cv::Rect(24, 15, 6, 30), cv::Rect(50, 15, 6, 30), cv::Rect(29, 15, 1, 30)}) {
    auto depth = with_body();
    depth(shadow) = 0;
    EXPECT_TRUE(same_pixels(mask_of(depth), rounded(kNearBody))) << shadow;
  }
}

TEST(DepthMasker, ReadingsThatDropOutOfABodyAreFilledAndOfTheRoomTheyAreNothing) {
  auto depth = with_body();
  depth.at<ushort>(25, 40) = 0;
  depth(cv::Rect(33, 30, 2, 1)) = 0;
  depth.at<ushort>(25, kNearBody.x) = 0;  // On its edge.
  depth.at<ushort>(5, 5) = 0;
  EXPECT_TRUE(same_pixels(mask_of(depth), rounded(kNearBody)));
}

TEST(DepthMasker, ASmallHoleInABodyIsBodyAndALargeOneIsSeenThrough) {
  // 4800 pixels: a thousandth is 4.
  auto small = with_body();
  small(cv::Rect(38, 28, 2, 2)) = 0;
  EXPECT_TRUE(same_pixels(mask_of(small), rounded(kNearBody)));
  auto large = with_body();
  large(cv::Rect(35, 25, 8, 8)) = 0;
  EXPECT_EQ(mask_of(large).at<uchar>(29, 39), 0);
}

TEST(DepthMasker, ASingleWrongReadingIsNoBody) {
  auto depth = depth_room();
  depth.at<ushort>(10, 10) = 1000;
  depth(cv::Rect(60, 40, 1, 9)) = 1000;
  EXPECT_EQ(cv::countNonZero(mask_of(depth)), 0);
}

TEST(DepthMasker, BeforeAnUnknownRoomIsBodyWhatGoesOnFromKnownBody) {
  // The right half of the depth_room is glass: it gives no depth.
  auto before = depth_room();
  before(cv::Rect(40, 0, 40, 60)) = 0;
  EXPECT_TRUE(same_pixels(mask_of(with_body(2000, before), before), rounded(kNearBody)));
  auto reflection = before.clone();
  reflection(cv::Rect(60, 20, 10, 10)) = 2000;
  EXPECT_EQ(cv::countNonZero(mask_of(reflection, before)), 0) << "it goes on from nothing";
  auto behind = with_body(2000, before);
  behind(cv::Rect(50, 15, 10, 30)) = 2900;
  EXPECT_TRUE(same_pixels(mask_of(behind, before), rounded(kNearBody))) << "it touches the body, a jump behind it";
}

TEST(DepthMasker, WithAFarPlaneWhatIsNearerIsBodyBeforeAnUnknownRoomToo) {
  DepthOptions options;
  options.far_mm = 2500;
  EXPECT_TRUE(same_pixels(mask_of(with_body(2000, depth_room(0)), depth_room(0), options), rounded(kNearBody)));
  EXPECT_EQ(cv::countNonZero(mask_of(with_body(2600, depth_room(0)), depth_room(0), options)), 0);
  EXPECT_EQ(cv::countNonZero(mask_of(with_body(2600), depth_room(), options)), 0) << "nor before a known one";
  options.near_mm = 2100;
  EXPECT_EQ(cv::countNonZero(mask_of(with_body(2000), depth_room(), options)), 0);
}

TEST(DepthMasker, NothingIsBodyOutsideTheRegionOfInterest) {
  auto options = mask_options();
  options.roi = {0, 0, 0.5, 1};
  EXPECT_EQ(cv::countNonZero(mask_of(with_body(), depth_room(), {}, options)(cv::Rect(40, 0, 40, 60))), 0);
  options.roi = {};
  options.ignore = {{0.25, 0, 1, 1}};
  EXPECT_EQ(cv::countNonZero(mask_of(with_body(), depth_room(), {}, options)), 0);
}

TEST(DepthMasker, DepthIsKnownWhereThereIsAReadingOrABodyAroundAHole) {
  auto depth = with_body();
  depth.at<ushort>(25, 40) = 0;
  depth(cv::Rect(0, 0, 10, 60)) = 0;
  DepthMasker masker(known(depth_room()), {}, mask_options());
  const auto result = masker.process(depth, 0);
  EXPECT_EQ(cv::countNonZero(~result.known), 600);
  EXPECT_EQ(result.known.at<uchar>(25, 40), 255);
}

TEST(DepthMasker, APictureWithoutReadingsShowsNobody) {
  for (const int z : {0, 65535}) EXPECT_EQ(cv::countNonZero(mask_of(depth_room(z))), 0) << z;
  EXPECT_EQ(cv::countNonZero(mask_of(depth_room(1), depth_room(65535))), 0)
      << "everything at once is no body: the camera moved";
}

TEST(DepthMasker, WhatIsFartherThanTheRoomThreeTimesInARowIsTheRoom) {
  // A body was taken for the depth_room, and leaves.
  DepthMasker masker(known(with_body()), {}, mask_options());
  EXPECT_EQ(cv::countNonZero(masker.process(with_body(), 0).body), 0);
  (void)masker.process(depth_room(), 0.1);
  (void)masker.process(depth_room(), 0.2);
  EXPECT_EQ(cv::countNonZero(masker.process(with_body(), 0.3).body), 0) << "twice may be an error";
  for (int i = 0; i < 3; ++i) (void)masker.process(depth_room(), 0.4 + 0.1 * i);
  EXPECT_TRUE(same_pixels(masker.process(with_body(), 0.8).body, rounded(kNearBody)));
}

TEST(DepthMasker, AnUnknownPieceOfTheRoomIsLearnedWhereNoBodyIs) {
  DepthMasker masker(known(depth_room(0)), {}, mask_options());
  for (int i = 0; i < 3; ++i) (void)masker.process(depth_room(), 0.1 * i);
  EXPECT_TRUE(same_pixels(masker.process(with_body(), 0.5).body, rounded(kNearBody)));
}

/// At 30 and at 120 frames a second: how a masker goes through a scene, and what it makes of it.
class DepthMaskerAtEachRate : public ::testing::TestWithParam<int> {
 protected:
  /// Shows the picture for so long, in whole thirtieths of a second; the last mask.
  cv::Mat show(const cv::Mat& depth, double seconds) {
    cv::Mat mask;
    for (int i = 0, n = static_cast<int>(std::lround(seconds * GetParam())); i < n; ++i) {
      mask = masker.process(depth, double(frame++) / GetParam()).body;
    }
    return mask;
  }

  DepthMasker masker{known(depth_room()), {}, mask_options()};
  int frame = 0;
};
INSTANTIATE_TEST_SUITE_P(FramesPerSecond, DepthMaskerAtEachRate, ::testing::Values(30, 120));

const cv::Rect kDoor{20, 5, 40, 50};  // In a wall 3 m away, into a depth_room of 5 m.

cv::Mat open_door() {
  auto depth = depth_room();
  depth(kDoor) = 5000;
  return depth;
}

cv::Mat in_doorway(int z, cv::Rect where = kNearBody) {
  auto depth = open_door();
  depth(where) = z;
  return depth;
}

TEST_P(DepthMaskerAtEachRate, ADoorThatOpensAndClosesIsNoBody) {
  for (const double open_s : {0.1, 0.3, 5.0}) {
    EXPECT_EQ(cv::countNonZero(show(open_door(), open_s)), 0) << open_s;
    (void)show(depth_room(), 0.2);
    EXPECT_EQ(cv::countNonZero(show(depth_room(), 0.1)), 0) << open_s;
    EXPECT_TRUE(same_pixels(show(with_body(), 0.1), rounded(kNearBody))) << "before the closed door, " << open_s;
    EXPECT_TRUE(same_pixels(show(with_body(2970), 5), rounded(kNearBody))) << "and close to it, " << open_s;
    (void)show(depth_room(), 0.3);
  }
}

TEST_P(DepthMaskerAtEachRate, ADoorIsKnownAgainThoughReadingsScatterAndDropOut) {
  cv::RNG random(1);
  const auto show_noisy = [&](const cv::Mat& depth, double seconds) {
    int most = 0;
    for (int i = 0, n = static_cast<int>(std::lround(seconds * GetParam())); i < n; ++i) {
      cv::Mat noise(kDepthSize, CV_16SC1), dice(kDepthSize, CV_8UC1), noisy;
      random.fill(noise, cv::RNG::NORMAL, 0, 5);
      random.fill(dice, cv::RNG::UNIFORM, 0, 100);
      cv::add(depth, noise, noisy, cv::noArray(), CV_16U);
      noisy.setTo(0, dice < 3);
      most = std::max(most, cv::countNonZero(show(noisy, 1.0 / GetParam())));
    }
    return most;
  };
  EXPECT_EQ(show_noisy(depth_room(), 1), 0);
  EXPECT_EQ(show_noisy(open_door(), 1), 0);
  EXPECT_GT(show_noisy(depth_room(), 0.3), kDoor.area() * 0.9) << "body until it has been back for a while";
  EXPECT_EQ(show_noisy(depth_room(), 3), 0);
}

TEST_P(DepthMaskerAtEachRate, AGlimpseOfWhatIsBehindIsNotTheRoom) {
  (void)show(open_door(), 0.1);
  EXPECT_EQ(cv::countNonZero(show(depth_room(), 0.1)), 0) << "the door was never gone";
  (void)show(open_door(), 0.2);
  EXPECT_TRUE(same_pixels(show(depth_room(), 0.1), rounded(kDoor))) << "now it was";
}

TEST_P(DepthMaskerAtEachRate, ADoorThatSwingsAwayStepByStepIsKnownAgainWhereItWasAtFirst) {
  for (int z = 3000; z < 5000; z += 200) {
    auto depth = depth_room();
    depth(kDoor) = z;
    (void)show(depth, 0.3);
  }
  (void)show(depth_room(), 0.3);
  EXPECT_EQ(cv::countNonZero(show(depth_room(), 0.1)), 0);
}

TEST_P(DepthMaskerAtEachRate, ACurtainThatStaysOpenShowsTheRoomBehindIt) {
  (void)show(open_door(), 70);
  const cv::Rect beyond{30, 10, 20, 40};
  EXPECT_TRUE(same_pixels(show(in_doorway(4000, beyond), 1), rounded(beyond)))
      << "between the curtain and what is behind";
  EXPECT_EQ(cv::countNonZero(show(open_door(), 1)), 0);
  EXPECT_TRUE(same_pixels(show(depth_room(), 5), rounded(kDoor))) << "after a minute the curtain is forgotten";
}

TEST_P(DepthMaskerAtEachRate, WhoStandsStillInTheDoorwayIsNotTakenForTheDoor) {
  (void)show(open_door(), 1);
  EXPECT_TRUE(same_pixels(show(in_doorway(3000), 30), rounded(kNearBody))) << "at the depth of the leaf";
  const cv::Rect most{22, 5, 38, 50};  // 95 % of it, and a body's depth is not one.
  auto depth = in_doorway(3000, most);
  depth(cv::Rect(22, 5, 6, 50)) = 2940;
  EXPECT_TRUE(same_pixels(show(depth, 20), rounded(most)));
  EXPECT_TRUE(same_pixels(show(in_doorway(2940, kDoor), 5), rounded(kDoor))) << "filling it, nearer than the leaf was";
}

TEST_P(DepthMaskerAtEachRate, WhoseMarkWasTakenForTheRoomIsSeenThereAgain) {
  // Learned as depth_room, gone for a second, and back with an arm where it was not.
  DepthMasker learned(known(with_body()), {}, mask_options());
  masker = learned;
  (void)show(with_body(), 0.5);
  (void)show(depth_room(), 1);
  auto depth = with_body();
  const cv::Rect arm{50, 20, 14, 4};
  depth(arm) = 2000;
  EXPECT_GE(cv::countNonZero(show(depth, 10)), kNearBody.area() + arm.area() - 8);
}

TEST_P(DepthMaskerAtEachRate, ADoorThatClosesBehindThePerformerLeavesThePerformerAlone) {
  (void)show(open_door(), 1);
  (void)show(in_doorway(2000), 1);
  (void)show(with_body(), 0.3);
  EXPECT_TRUE(same_pixels(show(with_body(), 5), rounded(kNearBody)));
  EXPECT_EQ(cv::countNonZero(show(depth_room(), 0.1)), 0)
      << "nor was a piece of the door hidden by the performer forgotten";
}

TEST_P(DepthMaskerAtEachRate, StrayReadingsBeforeAnUnknownRoomAreNoRoom) {
  // The right half of the depth_room is glass.
  auto before = depth_room();
  const cv::Rect glass{40, 0, 40, 60};
  before(glass) = 0;
  masker = DepthMasker(known(before), {}, mask_options());
  auto stray = before.clone();
  stray(glass) = 1500;
  for (int i = 0; i < 20; ++i) {
    (void)show(stray, 1.0 / 30);
    (void)show(before, 0.4);
  }
  EXPECT_TRUE(same_pixels(show(with_body(2000, before), 1), rounded(kNearBody))) << "behind the stray readings";
  (void)show(stray, 0.3);
  EXPECT_EQ(cv::countNonZero(show(with_body(2000, before), 0.1)(glass)), 0) << "readings that last are the depth_room";
}

TEST_P(DepthMaskerAtEachRate, StrayReadingsBeyondTheRoomAreNoRoom) {
  for (int i = 0; i < 20; ++i) {
    (void)show(open_door(), 1.0 / 30);
    (void)show(depth_room(0), 0.4);
  }
  EXPECT_EQ(cv::countNonZero(show(depth_room(), 0.1)), 0);
}

TEST_P(DepthMaskerAtEachRate, ReadingsThatDropOutNowAndThenDoNotHideWhatIsBehind) {
  for (int i = 0; i < 5; ++i) {
    (void)show(open_door(), 1.0 / 30);
    (void)show(depth_room(0), 2.0 / 30);
  }
  EXPECT_TRUE(same_pixels(show(in_doorway(4000), 0.1), rounded(kNearBody)));
}

TEST(DepthMasker, SlowDriftIsFollowedOutsideTheBodyAndNotInside) {
  auto options = mask_options();
  options.follow_s = 10;
  DepthMasker masker(known(depth_room()), {}, options);
  // A Kinect warms up: 1 mm a second, 60 in all, and the body stays 30 mm before the wall.
  cv::Mat mask;
  for (int s = 0; s <= 60; ++s) mask = masker.process(with_body(2970 - s, depth_room(3000 - s)), s).body;
  EXPECT_TRUE(same_pixels(mask, rounded(kNearBody)));
  options.follow_s = 0;
  options.sudden_percent = 100;
  DepthMasker rigid(known(depth_room()), {}, options);
  EXPECT_GT(cv::countNonZero(rigid.process(depth_room(2940), 0).body), 4700) << "who does not follow sees a body there";
}

TEST(DepthMasker, WhenMostOfTheRoomIsElsewhereTheCameraMovedAndTheRoomIsLearnedAnew) {
  auto options = mask_options();
  options.relearn_s = 1;
  DepthMasker masker(known(depth_room()), {}, options);
  const auto moved = masker.process(depth_room(2500), 0);
  EXPECT_TRUE(moved.sudden);
  EXPECT_TRUE(moved.learning);
  EXPECT_EQ(cv::countNonZero(moved.body), 0);
  EXPECT_TRUE(masker.process(depth_room(2500), 0.5).learning);
  const auto after = masker.process(depth_room(2500), 1.0);
  EXPECT_FALSE(after.learning);
  EXPECT_FALSE(after.sudden);
  EXPECT_TRUE(same_pixels(masker.process(with_body(2000, depth_room(2500)), 1.1).body, rounded(kNearBody)));
  options.sudden_percent = 100;
  DepthMasker steadfast(known(depth_room()), {}, options);
  EXPECT_FALSE(steadfast.process(depth_room(2500), 0).sudden);
}

TEST(DepthMasker, DoesNotWriteToTheRoomItWasGiven) {
  const auto background = known(with_body());
  DepthMasker masker(background, {}, mask_options());
  for (int i = 0; i < 5; ++i) (void)masker.process(depth_room(), i);
  EXPECT_TRUE(same_pixels(background.depth_mm, with_body()));
}

TEST(DepthOptions, WhatIsOutOfRangeIsRefusedByName) {
  const auto refused = [](auto change) {
    DepthOptions options;
    change(options);
    const auto error = error_of([&] { options.validate(); });
    return error && error->fault() == Fault::kUsage ? std::string(error->what()) + "; " + error->hint() : "";
  };
  EXPECT_EQ(refused([](auto&) {}), "");
  EXPECT_NE(refused([](auto& o) { o.threshold_mm = 0; }).find("depth.threshold_mm is 0"), std::string::npos);
  EXPECT_NE(refused([](auto& o) { o.threshold_mm = 5001; }), "");
  EXPECT_NE(refused([](auto& o) { o.spread_factor = 0.5; }), "");
  EXPECT_NE(refused([](auto& o) { o.least_threshold_mm = 0; }), "");
  EXPECT_NE(refused([](auto& o) { o.near_mm = -1; }), "");
  EXPECT_NE(refused([](auto& o) { o.far_mm = std::numeric_limits<double>::quiet_NaN(); }), "");
  EXPECT_NE(refused([](auto& o) {
              o.near_mm = 3000;
              o.far_mm = 3000;
            }).find("the far plane lies behind the near one"),
            std::string::npos);
}

}  // namespace
}  // namespace choreo::vision
