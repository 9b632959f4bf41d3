// SPDX-License-Identifier: Apache-2.0
// What the light and the scene do while a body is watched.
#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "support/drawn_masks.hpp"
#include "vision/body_masker.hpp"
#include "vision/scenes.hpp"

namespace choreo::vision {
namespace {

using test::figure_mask;
using test::in_light;
using test::iou;
using test::kRed;
using test::same_bytes;
using test::textured_wall;
using test::with_body;
using test::with_noise;

const cv::Size kLitSize(160, 120);

/// A wall nobody has seen before, quite unlike `textured_wall`.
cv::Mat other_wall() {
  cv::Mat wall(kLitSize, CV_8UC3);
  for (int y = 0; y < wall.rows; ++y) {
    for (int x = 0; x < wall.cols; ++x) {
      const bool light = (x / 20 + y / 20) % 2 == 0;
      wall.at<cv::Vec3b>(y, x) = light ? cv::Vec3b(210, 180, 60) : cv::Vec3b(20, 70, 30);
    }
  }
  return wall;
}

cv::Mat body_at(int k) { return figure_mask(kLitSize, {60 + k % 40, 60}, 90); }

TEST(BodyMaskerLight, ASlowDriftIsFollowedWhileTheBodyStays) {
  const auto wall = textured_wall(kLitSize);
  BodyMasker masker(wall, 1, {});
  const auto body = body_at(0);
  for (int k = 0; k < 300; ++k) {
    // Three levels a second, thirty in all: three times the threshold.
    const auto picture = with_noise(with_body(in_light(wall, 1, k * 0.1), body, kRed), 1, std::uint64_t(k));
    const auto result = masker.process(picture, k / 30.0);
    ASSERT_TRUE(result.body) << k;
    ASSERT_FALSE(result.sudden || result.learning) << k;
    ASSERT_GT(iou(result.mask, body), 0.95) << k;
  }
}

TEST(BodyMaskerLight, TheRunningBackgroundAloneFollowsItWhereTheBodyMovesAbout) {
  const auto wall = textured_wall(kLitSize);
  MaskOptions options;
  options.follow_exposure = false;
  options.follow_s = 1;
  BodyMasker masker(wall, 1, options);
  for (int k = 0; k < 300; ++k) {
    const auto body = figure_mask(kLitSize, {80 + static_cast<int>(std::lround(50 * std::sin(k * 0.1))), 60}, 90);
    const auto picture = with_noise(with_body(in_light(wall, 1, k * 0.1), body, kRed), 1, std::uint64_t(k));
    ASSERT_GT(iou(masker.process(picture, k / 30.0).mask, body), 0.95) << k;
  }
}

TEST(BodyMaskerLight, WithNothingFollowedTheSameDriftDrownsTheBody) {
  const auto wall = textured_wall(kLitSize);
  MaskOptions options;
  options.follow_exposure = false;
  options.follow_s = 0;
  options.sudden_percent = 100;
  BodyMasker masker(wall, 1, options);
  const auto body = body_at(0);
  EXPECT_LT(iou(masker.process(with_body(in_light(wall, 1, 30), body, kRed), 0).mask, body), 0.5);
}

TEST(BodyMaskerLight, AnUnevenDriftIsLearnedBesideTheBody) {
  // Light from the left: no curve of levels explains it.
  const auto wall = textured_wall(kLitSize);
  MaskOptions options;
  options.follow_s = 1;
  BodyMasker masker(wall, 1, options);
  const auto body = body_at(20);
  for (int k = 0; k < 300; ++k) {
    cv::Mat lit = wall.clone();
    for (int x = 0; x < lit.cols; ++x) lit.col(x) += cv::Scalar::all(k * 0.1 * (1.0 - double(x) / lit.cols));
    const auto result = masker.process(with_body(lit, body, kRed), k / 30.0);
    ASSERT_GT(iou(result.mask, body), 0.95) << k;
  }
}

TEST(BodyMaskerLight, AStandingBodyIsNeverLearnedAway) {
  const auto wall = textured_wall(kLitSize);
  MaskOptions options;
  options.follow_s = 0.5;
  BodyMasker masker(wall, 1, options);
  const auto body = body_at(0);
  for (int k = 0; k < 300; ++k) {
    const auto result = masker.process(with_noise(with_body(wall, body, kRed), 1, std::uint64_t(k)), k / 10.0);
    ASSERT_GT(iou(result.mask, body), 0.97) << k;
  }
}

TEST(BodyMaskerLight, AChangeOfExposureIsAbsorbed) {
  const auto wall = textured_wall(kLitSize);
  BodyMasker masker(wall, 1, {});
  int k = 0;
  for (const double gain : {1.0, 0.95, 1.06, 0.9, 1.12, 1.0}) {
    for (int repeat = 0; repeat < 3; ++repeat, ++k) {
      const auto body = body_at(2 * k);
      const auto picture = with_noise(in_light(with_body(wall, body, kRed), gain), 1, std::uint64_t(k));
      const auto result = masker.process(picture, k / 30.0);
      ASSERT_TRUE(result.body) << gain;
      EXPECT_FALSE(result.learning);
      EXPECT_GT(iou(result.mask, body), 0.95) << gain;
    }
  }
}

TEST(BodyMaskerLight, AChangeOfWhiteBalanceInTheEmptyRoomIsNoBody) {
  const auto wall = textured_wall(kLitSize);
  BodyMasker masker(wall, 1, {});
  for (int k = 0; k < 10; ++k) {
    cv::Mat tinted;
    cv::multiply(wall, cv::Scalar(1 - 0.01 * k, 1, 1 + 0.01 * k), tinted);
    EXPECT_FALSE(masker.process(with_noise(tinted, 1, std::uint64_t(k)), k / 30.0).body) << k;
  }
}

TEST(BodyMaskerLight, ASuddenChangeOfLightIsSaidAtThatFrameAndTheBodyIsFoundInIt) {
  const auto wall = textured_wall(kLitSize);
  for (const double gain : {0.6, 1.5}) {
    for (const bool follow_exposure : {true, false}) {
      MaskOptions options;
      options.follow_exposure = follow_exposure;
      BodyMasker masker(wall, 1, options);
      for (int k = 0; k < 20; ++k) {
        const auto body = body_at(k);
        const auto scene = with_body(wall, body, kRed);
        const auto picture = with_noise(k < 10 ? scene : in_light(scene, gain), 1, std::uint64_t(k));
        const auto result = masker.process(picture, k / 30.0);
        EXPECT_EQ(result.sudden, k == 10) << gain << " " << k;
        EXPECT_FALSE(result.learning) << gain << " " << k;
        ASSERT_TRUE(result.body) << gain << " " << k;
        EXPECT_GT(iou(result.mask, body), 0.93) << gain << " " << k;
      }
    }
  }
}

TEST(BodyMaskerLight, ANewSceneIsLearnedAndThenTheBodyIsFoundBeforeIt) {
  const auto wall = textured_wall(kLitSize);
  const auto elsewhere = other_wall();
  MaskOptions options;
  options.relearn_s = 0.5;
  BodyMasker masker(wall, 1, options);
  for (int k = 0; k < 60; ++k) {
    const auto body = body_at(k);
    const bool changed = k >= 10;
    // The new room is empty while it is learned.
    const bool there = !changed || k >= 30;
    const auto scene = changed ? elsewhere : wall;
    const auto picture = with_noise(there ? with_body(scene, body, kRed) : scene, 1, std::uint64_t(k));
    const auto result = masker.process(picture, k / 30.0);
    EXPECT_EQ(result.sudden, k == 10) << k;
    // From the change at 10/30 s for half a second: until the frame at 25/30 s.
    EXPECT_EQ(result.learning, k >= 10 && k < 25) << k;
    EXPECT_EQ(result.body, there) << k;
    if (there && result.body) {
      EXPECT_GT(iou(result.mask, body), 0.93) << k;
    }
  }
}

TEST(BodyMaskerLight, ASceneThatChangesAgainWhileItIsLearnedIsLearnedAnew) {
  const auto wall = textured_wall(kLitSize);
  const auto between = other_wall();
  const auto last = cv::Mat(255 - between);
  MaskOptions options;
  options.relearn_s = 0.5;
  BodyMasker masker(wall, 1, options);
  for (int k = 0; k < 90; ++k) {
    // Fifteen pictures are learned from, and only the last five of them show what comes to stay.
    const auto scene = k < 10 ? wall : k < 20 ? between : last;
    const auto result = masker.process(with_noise(scene, 1, std::uint64_t(k)), k / 30.0);
    EXPECT_FALSE(result.body) << k;
    if (k >= 60) {
      EXPECT_FALSE(result.learning || result.sudden) << k;
    }
  }
}

TEST(BodyMaskerLight, WithNoTimeToLearnTheFrameItselfIsTheNewWall) {
  MaskOptions options;
  options.relearn_s = 0;
  BodyMasker masker(textured_wall(kLitSize), 1, options);
  EXPECT_FALSE(masker.process(textured_wall(kLitSize), 0).sudden);
  const auto changed = masker.process(other_wall(), 0.1);
  EXPECT_TRUE(changed.sudden);
  EXPECT_FALSE(changed.body || changed.learning);
  const auto body = body_at(0);
  const auto result = masker.process(with_body(other_wall(), body, kRed), 0.2);
  EXPECT_GT(iou(result.mask, body), 0.95);
}

TEST(BodyMaskerLight, SwitchedOffASuddenChangeIsNotSaid) {
  MaskOptions options;
  options.sudden_percent = 100;
  BodyMasker masker(textured_wall(kLitSize), 1, options);
  (void)masker.process(textured_wall(kLitSize), 0);
  const auto result = masker.process(other_wall(), 0.1);
  EXPECT_FALSE(result.sudden || result.learning);
  EXPECT_TRUE(result.body);
}

TEST(BodyMaskerLight, TheSamePicturesTwiceGiveTheSameBytes) {
  const auto wall = textured_wall(kLitSize);
  MaskOptions options;
  options.relearn_s = 0.1;
  options.follow_s = 0.5;
  BodyMasker first(wall, 1, options);
  BodyMasker second(wall, 1, options);
  for (int k = 0; k < 60; ++k) {
    const auto scene = k < 30 ? in_light(wall, 1, k * 0.5) : other_wall();
    const auto picture = with_noise(with_body(scene, body_at(k), kRed), 3, std::uint64_t(k));
    const auto a = first.process(picture, k / 30.0);
    const auto b = second.process(picture.clone(), k / 30.0);
    ASSERT_TRUE(same_bytes(a.mask, b.mask)) << k;
    ASSERT_EQ(a.body, b.body);
    ASSERT_EQ(a.sudden, b.sudden);
    ASSERT_EQ(a.learning, b.learning);
    ASSERT_EQ(a.cut, b.cut);
  }
}

}  // namespace
}  // namespace choreo::vision
