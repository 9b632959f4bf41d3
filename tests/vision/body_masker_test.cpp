// SPDX-License-Identifier: Apache-2.0
// From picture to mask: threshold, places, sizes and borders. Light is tested in body_masker_light_test.cpp.
#include "vision/body_masker.hpp"

#include <functional>
#include <limits>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/error.hpp"
#include "support/drawn_masks.hpp"
#include "vision/scenes.hpp"

namespace choreo::vision {
namespace {

using test::figure_mask;
using test::iou;
using test::same_bytes;
using test::textured_wall;
using test::with_body;
using test::with_noise;

const cv::Size kMaskerSize(100, 80);
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Only the difference and the threshold: everything else is off.
MaskOptions bare(double threshold) {
  MaskOptions options;
  options.threshold = threshold;
  options.steps = 0;
  options.half_contrast_edge = false;
  options.drop_soft_light = false;
  options.speck_percent = 0;
  options.min_body_percent = 0;
  options.follow_exposure = false;
  options.follow_s = 0;
  options.sudden_percent = 100;
  return options;
}

cv::Mat grey_wall(cv::Size size = kMaskerSize, int level = 100) { return {size, CV_8UC3, cv::Scalar::all(level)}; }

MaskResult one(const cv::Mat& plate, const cv::Mat& picture, const MaskOptions& options, double noise = 1) {
  return BodyMasker(plate, noise, options).process(picture, 0.0);
}

cv::Mat with_box(cv::Mat picture, cv::Rect box, int level) {
  picture(box) = cv::Scalar::all(level);
  return picture;
}

cv::Mat box_mask(cv::Size size, cv::Rect box) {
  cv::Mat mask = cv::Mat::zeros(size, CV_8UC1);
  mask(box) = 255;
  return mask;
}

TEST(BodyMasker, APixelMustDifferByMoreThanTheThreshold) {
  const cv::Rect box(20, 20, 30, 30);
  EXPECT_FALSE(one(grey_wall(), with_box(grey_wall(), box, 120), bare(20)).body);
  const auto result = one(grey_wall(), with_box(grey_wall(), box, 121), bare(20));
  EXPECT_TRUE(result.body);
  EXPECT_EQ(result.area, 900);
  EXPECT_TRUE(same_bytes(result.mask, box_mask(kMaskerSize, box)));
  EXPECT_TRUE(one(grey_wall(), with_box(grey_wall(), box, 79), bare(20)).body) << "darker counts as well";
}

TEST(BodyMasker, WithoutAThresholdItFollowsFromTheNoiseAndHasAFloor) {
  MaskOptions options;
  EXPECT_EQ(BodyMasker(grey_wall(), 5, options).threshold(), 20);  // 4 times the noise.
  EXPECT_EQ(BodyMasker(grey_wall(), 1, options).threshold(), 10);
  EXPECT_EQ(BodyMasker(grey_wall(), 0, options).threshold(), 10);
  options.noise_factor = 6;
  options.least_threshold = 3;
  EXPECT_EQ(BodyMasker(grey_wall(), 5, options).threshold(), 30);
  EXPECT_EQ(BodyMasker(grey_wall(), 0.1, options).threshold(), 3);
  options.threshold = 7.5;
  EXPECT_EQ(BodyMasker(grey_wall(), 50, options).threshold(), 7.5) << "a given one is taken as it is";
}

TEST(BodyMasker, StepsCloseGapsInTheBody) {
  auto picture = with_box(grey_wall(), {20, 20, 15, 30}, 200);
  picture = with_box(picture, {39, 20, 15, 30}, 200);  // A gap of four columns.
  auto options = bare(20);
  options.steps = 1;
  EXPECT_EQ(one(grey_wall(), picture, options).area, 900);
  options.steps = 2;
  EXPECT_EQ(one(grey_wall(), picture, options).area, 900 + 4 * 30);
}

TEST(BodyMasker, OnlyTheRegionOfInterestIsLookedAt) {
  const auto picture = grey_wall(kMaskerSize, 200);
  auto options = bare(20);
  // 100 x 80 pixels: columns 25 to 49, rows 8 to 39.
  options.roi = {0.25, 0.1, 0.5, 0.5};
  EXPECT_TRUE(same_bytes(one(grey_wall(), picture, options).mask, box_mask(kMaskerSize, {25, 8, 25, 32})));
  options.roi = {0, 0, 1, 0.5};
  EXPECT_EQ(one(grey_wall(), picture, options).area, 100 * 40);
}

TEST(BodyMasker, IgnoredZonesAreCutOutOfTheRegionOfInterest) {
  auto options = bare(20);
  options.roi = {0, 0, 0.5, 1};
  options.ignore = {{0.1, 0.25, 0.2, 0.5}, {0.4, 0, 1, 1}};
  auto expected = box_mask(kMaskerSize, {0, 0, 40, 80});
  expected(cv::Rect(10, 20, 10, 20)) = 0;
  EXPECT_TRUE(same_bytes(one(grey_wall(), grey_wall(kMaskerSize, 200), options).mask, expected));
}

TEST(BodyMasker, ZonesThatLeaveNothingLeaveNoBody) {
  auto options = bare(20);
  options.ignore = {{0, 0, 1, 1}};
  EXPECT_FALSE(one(grey_wall(), grey_wall(kMaskerSize, 200), options).body);
  options.ignore = {};
  options.roi = {0.5, 0.5, 0.5001, 0.5001};  // Less than a pixel.
  EXPECT_FALSE(one(grey_wall(), grey_wall(kMaskerSize, 200), options).body);
}

TEST(BodyMasker, OfSeveralComponentsAllAreKeptOrTheLargestAlone) {
  auto picture = with_box(grey_wall(), {5, 5, 20, 20}, 200);
  picture = with_box(picture, {50, 5, 20, 40}, 200);
  auto options = bare(20);
  EXPECT_EQ(one(grey_wall(), picture, options).area, 400 + 800);
  options.largest_only = true;
  EXPECT_TRUE(same_bytes(one(grey_wall(), picture, options).mask, box_mask(kMaskerSize, {50, 5, 20, 40})));
}

TEST(BodyMasker, ComponentsBelowTheSpecksShareGo) {
  auto picture = with_box(grey_wall(), {5, 5, 4, 10}, 200);  // 40 of 8000 pixels: 0.5 %.
  picture = with_box(picture, {50, 5, 13, 3}, 200);          // 39.
  auto options = bare(20);
  options.speck_percent = 0.5;
  EXPECT_TRUE(same_bytes(one(grey_wall(), picture, options).mask, box_mask(kMaskerSize, {5, 5, 4, 10})));
}

TEST(BodyMasker, ABodyHasAtLeastItsShareOfThePicture) {
  auto options = bare(20);
  options.min_body_percent = 0.5;  // 40 of 8000 pixels.
  EXPECT_TRUE(one(grey_wall(), with_box(grey_wall(), {5, 5, 4, 10}, 200), options).body);
  const auto less = one(grey_wall(), with_box(grey_wall(), {5, 5, 13, 3}, 200), options);
  EXPECT_FALSE(less.body);
  EXPECT_EQ(less.area, 0);
  EXPECT_EQ(cv::countNonZero(less.mask), 0) << "no body, no mask";
  EXPECT_FALSE(less.cut);
}

TEST(BodyMasker, TheEmptyRoomHasNoBodyEvenIfNoneWouldBeSmallEnough) {
  const auto result = one(grey_wall(), grey_wall(), bare(20));
  EXPECT_FALSE(result.body);
  EXPECT_EQ(result.mask.size(), kMaskerSize);
  EXPECT_EQ(result.mask.type(), CV_8UC1);
}

TEST(BodyMasker, ABodyIsCutWhereItTouchesABorder) {
  struct Case {
    cv::Rect box;
    bool cut;
  };
  for (const auto& c : {Case{{1, 1, 98, 78}, false}, Case{{0, 30, 20, 20}, true}, Case{{30, 0, 20, 20}, true},
                        Case{{80, 30, 20, 20}, true}, Case{{30, 60, 20, 20}, true}, Case{{0, 0, 100, 80}, true},
                        Case{{79, 30, 20, 20}, false}, Case{{30, 59, 20, 20}, false}}) {
    EXPECT_EQ(one(grey_wall(), with_box(grey_wall(), c.box, 200), bare(20)).cut, c.cut) << c.box;
  }
}

TEST(BodyMasker, AFigureIsFoundWithDefaultSettings) {
  const cv::Size size(320, 240);
  const auto wall = textured_wall(size);
  for (const double sigma : {1.0, 4.0}) {
    BodyMasker masker(wall, sigma, {});
    for (int k = 0; k < 5; ++k) {
      const auto body = figure_mask(size, {100 + 20 * k, 120}, 180);
      const auto picture = with_noise(with_body(wall, body, cv::Scalar(40, 50, 190)), sigma, std::uint64_t(k));
      const auto result = masker.process(picture, k / 30.0);
      ASSERT_TRUE(result.body);
      EXPECT_GT(iou(result.mask, body), 0.97) << sigma << " " << k;
      EXPECT_FALSE(result.cut || result.sudden || result.learning);
      EXPECT_EQ(result.area, cv::countNonZero(result.mask));
    }
    EXPECT_FALSE(masker.process(with_noise(wall, sigma, 99), 1.0).body);
  }
}

TEST(BodyMasker, EveryResultStaysAsItWas) {
  const auto wall = textured_wall(kMaskerSize);
  BodyMasker masker(wall, 1, {});
  const auto first = masker.process(with_box(wall.clone(), {20, 20, 30, 30}, 240), 0.0);
  const auto copy = first.mask.clone();
  for (int k = 1; k < 5; ++k) (void)masker.process(with_box(wall.clone(), {20 + 4 * k, 20, 30, 30}, 240), k / 30.0);
  EXPECT_TRUE(same_bytes(first.mask, copy));
}

TEST(BodyMasker, ThePlateAndThePicturesAreNotWrittenTo) {
  const auto wall = textured_wall(kMaskerSize);
  const auto plate = wall.clone();
  const auto picture = test::in_light(with_box(wall.clone(), {20, 20, 30, 30}, 240), 1.1);
  const auto copy = picture.clone();
  BodyMasker masker(plate, 1, {});
  for (int k = 0; k < 5; ++k) (void)masker.process(picture, k / 30.0);
  EXPECT_TRUE(same_bytes(plate, wall));
  EXPECT_TRUE(same_bytes(picture, copy));
}

TEST(BodyMasker, TinyPicturesAreFine) {
  for (const auto size : {cv::Size(1, 1), cv::Size(1, 40), cv::Size(40, 1), cv::Size(2, 3)}) {
    for (const int level : {100, 101, 255}) {
      BodyMasker masker(grey_wall(size), 1, {});
      for (int k = 0; k < 4; ++k) {
        const auto result = masker.process(grey_wall(size, level), k * 0.6);
        EXPECT_EQ(result.mask.size(), size);
        EXPECT_EQ(result.body, result.area > 0);
        if (level < 102) {
          EXPECT_FALSE(result.body);
        }
      }
    }
  }
}

TEST(MaskOptions, TheDefaultsAndEveryBoundAreValid) {
  EXPECT_NO_THROW(MaskOptions{}.validate());
  MaskOptions least;
  least.threshold = 0.001;
  least.noise_factor = 1;
  least.least_threshold = 1;
  least.steps = 0;
  least.speck_percent = least.min_body_percent = 0;
  least.follow_s = least.relearn_s = 0;
  least.sudden_percent = 1;
  EXPECT_NO_THROW(least.validate());
  MaskOptions most;
  most.threshold = 255;
  most.noise_factor = 20;
  most.least_threshold = 255;
  most.steps = 32;
  most.speck_percent = most.min_body_percent = 100;
  most.follow_s = 3600;
  most.relearn_s = 60;
  most.sudden_percent = 100;
  EXPECT_NO_THROW(most.validate());
}

TEST(MaskOptions, EveryOptionBeyondItsBoundsIsRefusedByNameWithItsRange) {
  struct Case {
    std::string option;
    std::function<void(MaskOptions&)> spoil;
    std::string value;
  };
  for (const auto& c : std::vector<Case>{
           {"mask.threshold", [](auto& o) { o.threshold = 0; }, "0"},
           {"mask.threshold", [](auto& o) { o.threshold = 255.5; }, "255.5"},
           {"mask.threshold", [](auto& o) { o.threshold = kNan; }, "nan"},
           {"mask.noise_factor", [](auto& o) { o.noise_factor = 0.99; }, "0.99"},
           {"mask.noise_factor", [](auto& o) { o.noise_factor = 21; }, "21"},
           {"mask.least_threshold", [](auto& o) { o.least_threshold = 0.5; }, "0.5"},
           {"mask.least_threshold", [](auto& o) { o.least_threshold = 256; }, "256"},
           {"mask.steps", [](auto& o) { o.steps = -1; }, "-1"},
           {"mask.steps", [](auto& o) { o.steps = 33; }, "33"},
           {"mask.speck_percent", [](auto& o) { o.speck_percent = -0.1; }, "-0.1"},
           {"mask.speck_percent", [](auto& o) { o.speck_percent = 101; }, "101"},
           {"mask.min_body_percent", [](auto& o) { o.min_body_percent = -1; }, "-1"},
           {"mask.min_body_percent", [](auto& o) { o.min_body_percent = kNan; }, "nan"},
           {"mask.roi",
            [](auto& o) {
              o.roi = {0.5, 0, 0.5, 1};
            },
            "[0.5, 0, 0.5, 1]"},
           {"mask.roi",
            [](auto& o) {
              o.roi = {0, 0, 1, 1.1};
            },
            "1.1"},
           {"mask.roi",
            [](auto& o) {
              o.roi = {0, kNan, 1, 1};
            },
            "nan"},
           {"mask.ignore",
            [](auto& o) {
              o.ignore = {{}, {-0.1, 0, 1, 1}};
            },
            "-0.1"},
           {"mask.ignore",
            [](auto& o) {
              o.ignore = {{0, 0.8, 1, 0.2}};
            },
            "0.8"},
           {"background.follow_s", [](auto& o) { o.follow_s = -1; }, "-1"},
           {"background.follow_s", [](auto& o) { o.follow_s = 3601; }, "3601"},
           {"background.sudden_percent", [](auto& o) { o.sudden_percent = 0.5; }, "0.5"},
           {"background.sudden_percent", [](auto& o) { o.sudden_percent = 100.5; }, "100.5"},
           {"background.relearn_s", [](auto& o) { o.relearn_s = -0.5; }, "-0.5"},
           {"background.relearn_s", [](auto& o) { o.relearn_s = 61; }, "61"},
       }) {
    MaskOptions options;
    c.spoil(options);
    try {
      options.validate();
      ADD_FAILURE() << c.option << " " << c.value;
    } catch (const Error& error) {
      EXPECT_EQ(error.fault(), Fault::kUsage);
      EXPECT_NE(std::string(error.what()).find(c.option), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find(c.value), std::string::npos) << error.what();
      EXPECT_NE(error.hint().find(c.option), std::string::npos) << error.hint();
    }
    EXPECT_THROW(BodyMasker(grey_wall(), 1, options), Error) << "a masker is never made of such options";
  }
}

TEST(BodyMasker, SomebodyWhoStandsStillBeforeAWallThatWasSeenStaysABody) {
  BackgroundEstimate estimate;
  estimate.plate = textured_wall({160, 120});
  estimate.noise = 1;
  BodyMasker masker(estimate, {});
  const auto body = figure_mask({160, 120}, {80, 60}, 90);
  const auto there = with_body(estimate.plate, body, {40, 40, 160});
  for (int i = 0; i < 450; ++i) {
    const double time_s = 0.2 * i;
    const auto& scene = time_s < 2 ? estimate.plate : there;
    const auto result = masker.process(with_noise(scene, 1, std::uint64_t(i)), time_s);
    ASSERT_EQ(result.body, time_s >= 2) << time_s << " s";
    if (result.body) {
      ASSERT_GT(iou(result.mask, body), 0.9) << time_s << " s";
    }
  }
}

}  // namespace
}  // namespace choreo::vision
