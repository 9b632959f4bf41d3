// SPDX-License-Identifier: Apache-2.0
// Leaves in the wind, and what passes before them.
#include "vision/dynamic_background.hpp"

#include <cmath>
#include <cstdio>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "devices/synthetic/performer.hpp"
#include "support/outdoors.hpp"
#include "vision/background_estimate.hpp"
#include "vision/body_masker.hpp"
#include "vision/quiet_stretches.hpp"

namespace choreo::vision {
namespace {

std::vector<cv::Mat> masks_of(const test::Scene& film, const BackgroundEstimate& estimate) {
  BodyMasker masker(estimate, {});
  std::vector<cv::Mat> masks;
  for (std::size_t k = 0; k < film.pictures.size(); ++k) {
    masks.push_back(masker.process(film.pictures[k], double(k) / test::kOutdoorsFps).mask);
  }
  return masks;
}

TEST(DynamicBackground, WhoCrossesBeforeLeavesInTheWindIsSeenAndTheLeavesAreNot) {
  for (const double sway : {1.0, 3.0, 5.0}) {
    const auto garden_film = test::garden(sway, 11);
    auto estimate = estimate_background(garden_film.pictures, {});
    const double with = test::f_measure(masks_of(garden_film, estimate), garden_film.truths);
    estimate.dynamic = {};
    const double without = test::f_measure(masks_of(garden_film, estimate), garden_film.truths);
    std::printf("leaves that sway by %.0f px: F %.3f, and %.3f without\n", sway, with, without);
    EXPECT_GT(with, 0.93) << sway;
    EXPECT_GT(with, without) << sway;
  }
}

TEST(DynamicBackground, CarsOnARoadAreSeen) {
  const auto cars = test::road(10);
  QuietStretches quiet;
  for (std::size_t k = 0; k < cars.pictures.size(); ++k) quiet.add(cars.pictures[k], double(k) / test::kOutdoorsFps);
  const double f = test::f_measure(masks_of(cars, estimate_background(cars.pictures, quiet.finish())), cars.truths);
  std::printf("cars: F %.3f\n", f);
  EXPECT_GT(f, 0.9);
}

TEST(DynamicBackground, IsWhereLeavesMoveAndNotWhereSomebodyPasses) {
  const auto garden_film = test::garden(2, 11);
  const auto estimate = estimate_background(garden_film.pictures, {});
  cv::Mat beside = cv::Mat::zeros(test::kOutdoorsSize, CV_8UC1);
  beside(cv::Rect(0, 0, test::kTree.x - 8, test::kOutdoorsSize.height)).setTo(255);
  ASSERT_FALSE(estimate.dynamic.area().empty());
  EXPECT_EQ(cv::countNonZero(estimate.dynamic.area() & beside), 0);
  EXPECT_GT(cv::countNonZero(estimate.dynamic.area()), 0.6 * test::kTree.area());
}

TEST(DynamicBackground, AStillRoomHasNone) {
  const auto still = test::garden(0, 4);
  const auto estimate = estimate_background(still.pictures, {});
  EXPECT_TRUE(estimate.dynamic.area().empty());
}

// Who moves in place as leaves do is not like the wall beside them.
TEST(DynamicBackground, ADancerIsNone) {
  for (const auto* script : {"jumping-jacks", "side-kicks"}) {
    devices::synthetic::PerformerSettings settings;
    settings.size = {320, 240};
    settings.fps = test::kOutdoorsFps;
    settings.empty = 1;
    const devices::synthetic::Performer performer(script, settings);
    test::Scene dance;
    for (int k = 0; k < 6 * test::kOutdoorsFps; ++k) {
      const auto frame = performer.perform(k % performer.frame_count());
      dance.pictures.push_back(frame.bgr);
      dance.truths.emplace_back(frame.mask >= 128);
    }
    QuietStretches quiet;
    for (std::size_t k = 0; k < dance.pictures.size(); ++k)
      quiet.add(dance.pictures[k], double(k) / test::kOutdoorsFps);
    auto estimate = estimate_background(dance.pictures, quiet.finish());
    const double with = test::f_measure(masks_of(dance, estimate), dance.truths);
    estimate.dynamic = {};
    const double without = test::f_measure(masks_of(dance, estimate), dance.truths);
    std::printf("%s: F %.4f, and %.4f without\n", script, with, without);
    EXPECT_GT(with, without - 0.002) << script;
  }
}

TEST(Displaced, IsWhatTheBackgroundShowsSomePixelsOn) {
  cv::Mat wall(120, 160, CV_8UC3, cv::Scalar(100, 100, 100));
  wall(cv::Rect(50, 0, 2, 120)).setTo(cv::Scalar(20, 20, 20));
  cv::Mat picture(120, 160, CV_8UC3, cv::Scalar(100, 100, 100));
  picture(cv::Rect(53, 0, 2, 120)).setTo(cv::Scalar(20, 20, 20));
  const cv::Mat all(120, 160, CV_8UC1, cv::Scalar(255));
  cv::Mat asked = cv::Mat::zeros(120, 160, CV_8UC1);
  asked(cv::Rect(53, 0, 2, 60)).setTo(255);
  EXPECT_EQ(cv::countNonZero(displaced(asked, picture, wall, 10) != asked), 0) << "three pixels on";
  EXPECT_EQ(cv::countNonZero(displaced(all & ~asked, picture, wall, 10)(cv::Rect(53, 0, 2, 60))), 0) << "not asked";
  picture.setTo(cv::Scalar(60, 60, 60));
  EXPECT_EQ(cv::countNonZero(displaced(asked, picture, wall, 10)), 0) << "a colour that is nowhere";
}

}  // namespace
}  // namespace choreo::vision
