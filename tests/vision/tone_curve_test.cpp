// SPDX-License-Identifier: Apache-2.0
#include "vision/tone_curve.hpp"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "support/drawn_masks.hpp"
#include "vision/scenes.hpp"

namespace choreo::vision {
namespace {

using test::in_light;
using test::largest_difference;
using test::mean_difference;
using test::same_bytes;
using test::textured_wall;
using test::with_body;
using test::with_noise;

const cv::Size kCurveSize(160, 120);

/// All 256 levels, in every channel.
cv::Mat ramp() {
  cv::Mat out(1, 256, CV_8UC3);
  for (int level = 0; level < 256; ++level) out.at<cv::Vec3b>(0, level) = cv::Vec3b::all(static_cast<uchar>(level));
  return out;
}

TEST(ToneCurve, TheIdentityChangesNothing) { EXPECT_TRUE(same_bytes(ToneCurve().apply(ramp()), ramp())); }

TEST(ToneCurve, ThePictureItselfGivesTheIdentityAtEveryLevel) {
  const auto wall = textured_wall(kCurveSize);
  EXPECT_TRUE(same_bytes(ToneCurve(wall, wall).apply(ramp()), ramp()));
}

TEST(ToneCurve, AShiftOfAllLevelsIsFoundExactly) {
  const auto wall = textured_wall(kCurveSize);
  for (const int shift : {-40, -7, 1, 30}) {
    const auto to = in_light(wall, 1, shift);
    EXPECT_TRUE(same_bytes(ToneCurve(wall, to).apply(wall), to)) << shift;
  }
}

TEST(ToneCurve, ExposureAndWhiteBalanceAreFoundToALevelOrTwo) {
  const auto wall = textured_wall(kCurveSize);
  for (const double gain : {0.8, 0.9, 1.1, 1.25}) {
    const auto to = in_light(wall, gain);
    EXPECT_LE(largest_difference(ToneCurve(wall, to).apply(wall), to), 3) << gain;
    EXPECT_LE(mean_difference(ToneCurve(wall, to).apply(wall), to), 0.7) << gain;
  }
  cv::Mat warm;
  cv::multiply(wall, cv::Scalar(0.85, 1.0, 1.1), warm);
  EXPECT_LE(mean_difference(ToneCurve(wall, warm).apply(wall), warm), 0.7);
}

TEST(ToneCurve, RisesWithTheLevelWhateverThePictures) {
  cv::RNG random(5);
  for (int k = 0; k < 20; ++k) {
    cv::Mat from(40, 60, CV_8UC3);
    cv::Mat to(40, 60, CV_8UC3);
    random.fill(from, cv::RNG::UNIFORM, 0, 256);
    random.fill(to, cv::RNG::UNIFORM, 0, 256);
    const auto levels = ToneCurve(from, k % 2 == 0 ? to : cv::Mat(255 - from)).apply(ramp());
    for (int level = 1; level < 256; ++level) {
      for (int c = 0; c < 3; ++c) {
        ASSERT_GE(levels.at<cv::Vec3b>(0, level)[c], levels.at<cv::Vec3b>(0, level - 1)[c]) << level;
      }
    }
  }
}

TEST(ToneCurve, ABodyBeforeTheWallDoesNotBendIt) {
  const auto wall = textured_wall(kCurveSize);
  for (const auto& colour : {cv::Scalar(20, 20, 20), cv::Scalar(240, 240, 240), cv::Scalar(60, 40, 200)}) {
    // Four tenths of the picture, its noise with it.
    auto picture = wall.clone();
    picture(cv::Rect(40, 0, 64, 120)) = colour;
    picture = with_noise(in_light(picture, 1.1), 2, 3);
    const auto lit = ToneCurve(wall, picture).apply(wall);
    EXPECT_LE(mean_difference(lit, in_light(wall, 1.1)), 2.0) << colour;
  }
}

TEST(ToneCurve, WhatIsLeftOutHasNoSay) {
  const auto wall = textured_wall(kCurveSize);
  cv::Mat except = cv::Mat::zeros(kCurveSize, CV_8UC1);
  except(cv::Rect(0, 0, 150, 120)) = 255;
  cv::Mat picture = in_light(wall, 1, 10);
  // Nearly everything does alike, and wrongly so.
  in_light(wall, 1, -25).copyTo(picture, except);
  const auto lit = ToneCurve(wall, picture, except).apply(wall);
  EXPECT_TRUE(same_bytes(lit(cv::Rect(150, 0, 10, 120)).clone(), picture(cv::Rect(150, 0, 10, 120)).clone()));
}

TEST(ToneCurve, NoiseInThePictureIsAveragedAway) {
  const auto wall = textured_wall(kCurveSize);
  for (const double sigma : {1.0, 3.0, 6.0}) {
    const auto lit = ToneCurve(wall, with_noise(in_light(wall, 1.1), sigma, 4)).apply(wall);
    EXPECT_LE(mean_difference(lit, in_light(wall, 1.1)), 1.2) << sigma;
  }
}

TEST(ToneCurve, TooLittleToSeeGivesTheIdentity) {
  for (const auto size : {cv::Size(1, 1), cv::Size(1, 5), cv::Size(5, 1)}) {
    const cv::Mat from(size, CV_8UC3, cv::Scalar(10, 20, 30));
    const cv::Mat to(size, CV_8UC3, cv::Scalar(110, 120, 130));
    EXPECT_TRUE(same_bytes(ToneCurve(from, to).apply(ramp()), ramp()));
  }
  const auto wall = textured_wall(kCurveSize);
  const cv::Mat all(kCurveSize, CV_8UC1, cv::Scalar(255));
  EXPECT_TRUE(same_bytes(ToneCurve(wall, in_light(wall, 0.5), all).apply(ramp()), ramp()));
}

}  // namespace
}  // namespace choreo::vision
