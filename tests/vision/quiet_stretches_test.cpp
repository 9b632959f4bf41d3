// SPDX-License-Identifier: Apache-2.0
#include "vision/quiet_stretches.hpp"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "support/drawn_masks.hpp"
#include "vision/scenes.hpp"

namespace choreo::vision {
namespace {

using test::disc_mask;
using test::in_light;
using test::largest_difference;
using test::same_bytes;
using test::textured_wall;
using test::with_body;
using test::with_noise;

const cv::Size kQuietSize(160, 120);

cv::Mat with_disc(int x) {
  return with_body(textured_wall(kQuietSize), disc_mask(kQuietSize, {x, 60}, 15), cv::Scalar(30, 30, 200));
}

TEST(QuietStretches, NothingSeenIsNothingFound) { EXPECT_TRUE(QuietStretches().finish().empty()); }

TEST(QuietStretches, OnePictureIsNoStretch) {
  QuietStretches quiet;
  quiet.add(textured_wall(kQuietSize), 0);
  EXPECT_TRUE(quiet.finish().empty());
}

TEST(QuietStretches, AStandingPictureIsOneStretchAndItsMeanHasLessNoise) {
  QuietStretches quiet;
  for (int k = 0; k < 40; ++k) quiet.add(with_noise(textured_wall(kQuietSize), 4, std::uint64_t(k)), k / 30.0);
  const auto found = quiet.finish();
  ASSERT_EQ(found.size(), 1U);
  // Noise of 4 over 40 pictures is 0.63, and rounding adds a little.
  EXPECT_LT(test::mean_difference(found[0], textured_wall(kQuietSize)), 0.7);
}

TEST(QuietStretches, AMovingBodyEndsThem) {
  QuietStretches quiet;
  for (int k = 0; k < 60; ++k) quiet.add(with_disc(20 + 2 * k), k / 30.0);
  EXPECT_TRUE(quiet.finish().empty());
}

TEST(QuietStretches, TheLongestComesFirst) {
  QuietStretches quiet;
  double time_s = 0;
  for (const auto& [x, frames] : {std::pair{20, 15}, {60, 45}, {100, 30}, {140, 8}}) {
    for (int k = 0; k < frames; ++k, time_s += 1 / 30.0) quiet.add(with_disc(x), time_s);
  }
  const auto found = quiet.finish();
  ASSERT_EQ(found.size(), 3U) << "a quarter of a second is no stretch";
  EXPECT_TRUE(same_bytes(found[0], with_disc(60)));
  EXPECT_TRUE(same_bytes(found[1], with_disc(100)));
  EXPECT_TRUE(same_bytes(found[2], with_disc(20)));
}

TEST(QuietStretches, TheFirstAndTheLastAreKeptHoweverShortBesideManyLongOnes) {
  // Somebody who stands still in twenty postures, and the room for half a second before and after.
  QuietStretches quiet;
  double time_s = 0;
  const auto hold = [&](const cv::Mat& picture, int frames) {
    for (int k = 0; k < frames; ++k, time_s += 1 / 30.0) quiet.add(picture, time_s);
  };
  hold(textured_wall(kQuietSize), 20);
  for (int posture = 0; posture < 20; ++posture) hold(with_disc(20 + 5 * posture), 30);
  hold(in_light(textured_wall(kQuietSize), 0.8), 15);
  const auto found = quiet.finish();
  ASSERT_EQ(found.size(), 12U);
  EXPECT_TRUE(same_bytes(found[10], textured_wall(kQuietSize)));
  EXPECT_TRUE(same_bytes(found[11], in_light(textured_wall(kQuietSize), 0.8)));
}

TEST(QuietStretches, ItsLengthIsInSecondsNotInFrames) {
  // The same fifteen pictures, in half a second and in a quarter.
  for (const double fps : {30.0, 60.0}) {
    QuietStretches quiet;
    for (int k = 0; k < 15; ++k) quiet.add(textured_wall(kQuietSize), k / fps);
    EXPECT_EQ(quiet.finish().size(), fps < 40 ? 1U : 0U) << fps;
  }
}

TEST(QuietStretches, AChangeOfExposureDoesNotEndOne) {
  QuietStretches quiet;
  for (int k = 0; k < 30; ++k) quiet.add(in_light(textured_wall(kQuietSize), 1 + 0.005 * k), k / 30.0);
  EXPECT_EQ(quiet.finish().size(), 1U);
}

TEST(QuietStretches, FinishingStartsAnew) {
  QuietStretches quiet;
  for (int k = 0; k < 30; ++k) quiet.add(textured_wall(kQuietSize), k / 30.0);
  EXPECT_EQ(quiet.finish().size(), 1U);
  for (int k = 0; k < 3; ++k) quiet.add(with_disc(20 + 20 * k), 2 + k / 30.0);
  EXPECT_EQ(quiet.finish().size(), 1U) << "what was found stays found; nothing was added to it";
}

TEST(QuietStretches, TinyAndNarrowPicturesAreFine) {
  for (const auto size : {cv::Size(1, 1), cv::Size(1, 200), cv::Size(200, 1)}) {
    QuietStretches quiet;
    for (int k = 0; k < 20; ++k) quiet.add(cv::Mat(size, CV_8UC3, cv::Scalar::all(90)), k / 30.0);
    const auto found = quiet.finish();
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(largest_difference(found[0], cv::Mat(size, CV_8UC3, cv::Scalar::all(90))), 0);
  }
}

}  // namespace
}  // namespace choreo::vision
