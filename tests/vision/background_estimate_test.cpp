// SPDX-License-Identifier: Apache-2.0
// The wall behind the body: found where it can be, and doubted where it cannot.
#include "vision/background_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <opencv2/core.hpp>

#include "support/drawn_masks.hpp"
#include "vision/quiet_stretches.hpp"
#include "vision/scenes.hpp"

namespace choreo::vision {
namespace {

using test::disc_mask;
using test::figure_mask;
using test::in_light;
using test::kRed;
using test::mean_difference;
using test::same_bytes;
using test::textured_wall;
using test::with_body;
using test::with_noise;

const cv::Size kClipSize(160, 120);

std::vector<cv::Mat> crossing_disc(int count, double sigma) {
  std::vector<cv::Mat> pictures;
  for (int k = 0; k < count; ++k) {
    const auto body = disc_mask(kClipSize, {15 + 130 * k / count, 60}, 14);
    pictures.push_back(with_noise(with_body(textured_wall(kClipSize), body, kRed), sigma, std::uint64_t(k)));
  }
  return pictures;
}

struct Clip {
  std::vector<cv::Mat> pictures;  // A second's worth of every ten.
  std::vector<cv::Mat> quiet;
};

/// Ten seconds at 30 frames a second, of which the room is empty for the second from `empty_from` on; for the rest a
/// figure stands in one place and moves an arm now and then.
Clip mostly_standing(double sigma, int empty_from) {
  Clip clip;
  QuietStretches quiet;
  for (int k = 0; k < 300; ++k) {
    const bool empty = k >= empty_from && k < empty_from + 30;
    auto body = figure_mask(kClipSize, {80, 60}, 100);
    body(cv::Rect(92, 40 + 10 * (k / 20 % 3), 30, 7)) = 255;
    const auto scene = empty ? textured_wall(kClipSize) : with_body(textured_wall(kClipSize), body, kRed);
    const auto picture = with_noise(scene, sigma, std::uint64_t(k));
    quiet.add(picture, k / 30.0);
    if (k % 5 == 0) clip.pictures.push_back(picture);
  }
  clip.quiet = quiet.finish();
  return clip;
}

TEST(MedianPlate, IsTheMiddleValuePerChannel) {
  const std::vector<cv::Mat> pictures = {cv::Mat(2, 3, CV_8UC3, cv::Scalar(1, 50, 200)),
                                         cv::Mat(2, 3, CV_8UC3, cv::Scalar(9, 40, 0)),
                                         cv::Mat(2, 3, CV_8UC3, cv::Scalar(5, 255, 100))};
  EXPECT_TRUE(same_bytes(median_plate(pictures), cv::Mat(2, 3, CV_8UC3, cv::Scalar(5, 50, 100))));
  EXPECT_TRUE(same_bytes(median_plate(std::span(pictures).first(1)), pictures[0]));
}

TEST(MedianPlate, ShowsTheWallWhereMostPicturesDo) {
  const auto plate = median_plate(crossing_disc(40, 2));
  EXPECT_LT(mean_difference(plate, textured_wall(kClipSize)), 1.0);
}

TEST(EstimateBackground, ADiscThatCrossesLeavesNoTrace) {
  for (const double sigma : {0.5, 3.0}) {
    const auto estimate = estimate_background(crossing_disc(40, sigma), {});
    EXPECT_LT(mean_difference(estimate.plate, textured_wall(kClipSize)), 1.5) << sigma;
    EXPECT_LT(test::largest_difference(estimate.plate, textured_wall(kClipSize)), 10) << sigma;
    EXPECT_FALSE(estimate.uncertain()) << estimate.unseen;
    EXPECT_EQ(estimate.empty, 0.0);
  }
}

TEST(EstimateBackground, OneSecondOfTheEmptyRoomInTenIsEnough) {
  for (const int empty_from : {0, 135, 270}) {
    const auto clip = mostly_standing(2, empty_from);
    const auto estimate = estimate_background(clip.pictures, clip.quiet);
    EXPECT_LT(test::largest_difference(estimate.plate, textured_wall(kClipSize)), 12) << empty_from;
    EXPECT_FALSE(estimate.uncertain()) << estimate.unseen;
    EXPECT_NEAR(estimate.empty, 0.1, 0.04);
  }
}

TEST(EstimateBackground, WithoutItsQuietStretchesTheSameClipKeepsTheBodyInTheWall) {
  const auto clip = mostly_standing(2, 135);
  EXPECT_GT(mean_difference(estimate_background(clip.pictures, {}).plate, textured_wall(kClipSize)), 5.0);
}

TEST(EstimateBackground, TheNoiseIsMeasuredToAFifth) {
  for (const double sigma : {1.0, 3.0, 6.0}) {
    const auto standing = mostly_standing(sigma, 135);
    EXPECT_NEAR(estimate_background(standing.pictures, standing.quiet).noise, sigma, 0.2 * sigma);
    EXPECT_NEAR(estimate_background(crossing_disc(40, sigma), {}).noise, sigma, 0.2 * sigma);
  }
}

TEST(EstimateBackground, TheNoiseOfAFlatWallIsMeasuredToo) {
  for (const double sigma : {1.0, 3.0, 6.0}) {
    std::vector<cv::Mat> pictures;
    for (int k = 0; k < 20; ++k) {
      pictures.push_back(with_noise(cv::Mat(kClipSize, CV_8UC3, cv::Scalar::all(128)), sigma, std::uint64_t(k)));
    }
    EXPECT_NEAR(estimate_background(pictures, {}).noise, sigma, 0.2 * sigma);
  }
}

TEST(EstimateBackground, StepsOfExposureBetweenThePicturesDoNotMatter) {
  auto pictures = crossing_disc(40, 2);
  for (std::size_t k = 0; k < pictures.size(); ++k) {
    pictures[k] = in_light(pictures[k], k < 12 ? 0.9 : k < 25 ? 1.0 : 1.1);
  }
  const auto estimate = estimate_background(pictures, {});
  EXPECT_FALSE(estimate.uncertain()) << estimate.unseen;
  EXPECT_LT(estimate.noise, 3.0);
  // The plate is in one of the lights, and the same all over.
  double best = 255;
  for (const double gain : {0.9, 1.0, 1.1}) {
    best = std::min(best, test::largest_difference(estimate.plate, in_light(textured_wall(kClipSize), gain)));
  }
  EXPECT_LT(best, 12);
}

/// A performer who sways and beckons but never leaves: the middle of the trunk hides the same wall all the time.
std::vector<cv::Mat> never_leaving(int count, double sigma) {
  std::vector<cv::Mat> pictures;
  for (int k = 0; k < count; ++k) {
    const int x = 80 + static_cast<int>(std::lround(8 * std::sin(k * 0.7)));
    auto body = figure_mask(kClipSize, {x, 60}, 100);
    body(cv::Rect(k % 2 == 0 ? x + 10 : x - 40, 25 + 9 * (k % 5), 30, 7)) = 255;
    pictures.push_back(with_noise(with_body(textured_wall(kClipSize), body, kRed), sigma, std::uint64_t(k)));
  }
  return pictures;
}

TEST(EstimateBackground, APerformerWhoNeverLeavesMakesItUncertain) {
  const auto estimate = estimate_background(never_leaving(40, 2), {});
  EXPECT_TRUE(estimate.uncertain()) << estimate.unseen;
  EXPECT_EQ(estimate.empty, 0.0);
}

TEST(EstimateBackground, AnEmptyRoomIsCertain) {
  std::vector<cv::Mat> pictures;
  for (int k = 0; k < 20; ++k) pictures.push_back(with_noise(textured_wall(kClipSize), 3, std::uint64_t(k)));
  const auto estimate = estimate_background(pictures, {});
  EXPECT_FALSE(estimate.uncertain());
  EXPECT_EQ(estimate.unseen, 0.0);
  EXPECT_EQ(estimate.empty, 1.0);
  EXPECT_LT(mean_difference(estimate.plate, textured_wall(kClipSize)), 1.5);
}

TEST(EstimateBackground, OnePictureAndOnePixelAreFine) {
  for (const auto size : {cv::Size(1, 1), cv::Size(1, 20), cv::Size(20, 1), kClipSize}) {
    for (const int count : {1, 2, 3}) {
      const std::vector<cv::Mat> pictures(std::size_t(count), cv::Mat(size, CV_8UC3, cv::Scalar(90, 100, 110)));
      const auto estimate = estimate_background(pictures, pictures);
      EXPECT_TRUE(same_bytes(estimate.plate, pictures[0]));
      EXPECT_EQ(estimate.empty, 1.0);
      EXPECT_FALSE(estimate.uncertain());
    }
  }
}

TEST(EstimateBackground, OneThreadGivesTheSameBytesAsMany) {
  const auto clip = mostly_standing(3, 200);
  const auto many = estimate_background(clip.pictures, clip.quiet);
  const tbb::global_control single(tbb::global_control::max_allowed_parallelism, 1);
  const auto one = estimate_background(clip.pictures, clip.quiet);
  EXPECT_TRUE(same_bytes(one.plate, many.plate));
  EXPECT_EQ(one.noise, many.noise);
  EXPECT_EQ(one.unseen, many.unseen);
}

TEST(EstimateBackground, ThePicturesAreNotWrittenTo) {
  const auto pictures = crossing_disc(10, 2);
  auto copies = pictures;
  for (auto& copy : copies) copy = copy.clone();
  (void)estimate_background(pictures, std::span(pictures).first(2));
  for (std::size_t k = 0; k < pictures.size(); ++k) EXPECT_TRUE(same_bytes(pictures[k], copies[k]));
}

TEST(JudgePlate, AGoodPlateIsCertainAndTellsTheNoise) {
  const auto estimate = judge_plate(textured_wall(kClipSize), crossing_disc(30, 3));
  EXPECT_TRUE(same_bytes(estimate.plate, textured_wall(kClipSize)));
  EXPECT_NEAR(estimate.noise, 3, 0.6);
  EXPECT_FALSE(estimate.uncertain());
  EXPECT_EQ(estimate.empty, 0.0);
}

TEST(JudgePlate, APlateInAnotherLightIsJudgedInThePicturesLight) {
  const auto estimate = judge_plate(in_light(textured_wall(kClipSize), 0.85), crossing_disc(30, 2));
  EXPECT_NEAR(estimate.noise, 2, 0.6);
  EXPECT_FALSE(estimate.uncertain());
}

TEST(JudgePlate, TheEmptyPicturesAreCounted) {
  auto pictures = crossing_disc(30, 1);
  for (int k = 0; k < 10; ++k) pictures.push_back(with_noise(textured_wall(kClipSize), 1, std::uint64_t(k) + 50));
  EXPECT_DOUBLE_EQ(judge_plate(textured_wall(kClipSize), pictures).empty, 0.25);
}

TEST(JudgePlate, APlateWithTheTrunkInItIsDoubted) {
  const auto pictures = never_leaving(40, 1);
  EXPECT_TRUE(judge_plate(median_plate(pictures), pictures).uncertain());
}

}  // namespace
}  // namespace choreo::vision
