// SPDX-License-Identifier: Apache-2.0
#include "vision/soft_light.hpp"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "support/drawn_masks.hpp"
#include "vision/difference.hpp"
#include "vision/scenes.hpp"

namespace choreo::vision {
namespace {

using test::disc_mask;
using test::figure_mask;
using test::iou;
using test::same_bytes;
using test::textured_wall;
using test::with_body;
using test::with_noise;

const cv::Size kShadowSize(160, 120);
constexpr double kThreshold = 10;

/// `wall` dimmed to `depth` in an ellipse whose rim takes `softness` pixels.
cv::Mat with_shadow(const cv::Mat& wall, cv::Point center, cv::Size axes, double depth, double softness) {
  cv::Mat dim = cv::Mat::zeros(wall.size(), CV_32FC1);
  cv::ellipse(dim, center, axes, 0, 0, 360, cv::Scalar(1 - depth), cv::FILLED);
  cv::GaussianBlur(dim, dim, {}, softness);
  cv::Mat out = wall.clone();
  for (int y = 0; y < wall.rows; ++y) {
    for (int x = 0; x < wall.cols; ++x) {
      for (int c = 0; c < 3; ++c) {
        out.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<uchar>(wall.at<cv::Vec3b>(y, x)[c] * (1 - dim.at<float>(y, x)));
      }
    }
  }
  return out;
}

cv::Mat mask_between(const cv::Mat& picture, const cv::Mat& wall) {
  return difference_luminance(picture, wall) > kThreshold;
}

TEST(WithoutSoftLight, ASoftShadowOnATexturedFloorGoes) {
  for (const double sigma : {0.0, 2.0}) {
    const auto wall = textured_wall(kShadowSize);
    const auto picture = with_noise(with_shadow(wall, {80, 70}, {40, 12}, 0.7, 6), sigma, 1);
    const auto mask = annealed(mask_between(picture, wall), 1);
    ASSERT_GT(cv::countNonZero(mask), 1000) << "there must be something to take away";
    EXPECT_LT(cv::countNonZero(without_soft_light(mask, picture, wall)), 0.05 * cv::countNonZero(mask)) << sigma;
  }
}

TEST(WithoutSoftLight, ASoftGlowGoesToo) {
  const auto wall = textured_wall(kShadowSize);
  const auto picture = with_shadow(wall, {80, 60}, {40, 25}, 1.2, 8);
  const auto mask = mask_between(picture, wall);
  ASSERT_GT(cv::countNonZero(mask), 1000);
  EXPECT_LT(cv::countNonZero(without_soft_light(mask, picture, wall)), 0.05 * cv::countNonZero(mask));
}

TEST(WithoutSoftLight, AGreyShirtWithAnOutlineOnAGreyWallStays) {
  const cv::Mat wall(kShadowSize, CV_8UC3, cv::Scalar(140, 140, 140));
  const auto body = figure_mask(kShadowSize, {80, 60}, 90);
  // Shirts lighter still (110 and more) are a step of less than a fifth over a window: no more than a shadow's rim.
  for (const int grey : {60, 80, 100}) {
    const auto picture = with_body(wall, body, cv::Scalar::all(grey));
    const auto mask = mask_between(picture, wall);
    EXPECT_GT(iou(without_soft_light(mask, picture, wall), mask), grey < 100 ? 0.999 : 0.95) << grey;
  }
}

TEST(WithoutSoftLight, ABodyWithItsShadowKeepsTheBody) {
  const auto wall = textured_wall(kShadowSize);
  const auto body = figure_mask(kShadowSize, {70, 55}, 80);
  const auto picture = with_body(with_shadow(wall, {90, 96}, {45, 9}, 0.7, 5), body, cv::Scalar(50, 60, 170));
  const auto mask = mask_between(picture, wall);
  ASSERT_LT(iou(mask, body), 0.75) << "the shadow must matter";
  const auto out = without_soft_light(mask, picture, wall);
  EXPECT_GT(iou(out, body), 0.9);
  EXPECT_LT(cv::countNonZero(body & mask & ~out), 0.03 * cv::countNonZero(body));
}

TEST(WithoutSoftLight, AColouredPatchStaysHoweverSoftItsRim) {
  const cv::Mat wall(kShadowSize, CV_8UC3, cv::Scalar(140, 140, 140));
  cv::Mat weight = cv::Mat::zeros(kShadowSize, CV_32FC1);
  cv::circle(weight, {80, 60}, 25, cv::Scalar(1), cv::FILLED);
  cv::GaussianBlur(weight, weight, {}, 6);
  cv::Mat picture = wall.clone();
  for (int y = 0; y < wall.rows; ++y) {
    for (int x = 0; x < wall.cols; ++x) {
      // Red goes up as the others go down: no light does that.
      const float w = weight.at<float>(y, x);
      picture.at<cv::Vec3b>(y, x) =
          cv::Vec3b(cv::saturate_cast<uchar>(140 - 90 * w), cv::saturate_cast<uchar>(140 - 90 * w),
                    cv::saturate_cast<uchar>(140 + 90 * w));
    }
  }
  const auto mask = mask_between(picture, wall);
  const auto out = without_soft_light(mask, picture, wall);
  EXPECT_GT(cv::countNonZero(out), 0.85 * cv::countNonZero(mask));
  EXPECT_EQ(cv::countNonZero(disc_mask(kShadowSize, {80, 60}, 20) & ~out), 0);
}

TEST(WithoutSoftLight, NeverAddsAPixelAndNeverChangesItsInput) {
  cv::RNG random(9);
  for (int k = 0; k < 10; ++k) {
    const auto wall = with_noise(textured_wall(kShadowSize), 20, std::uint64_t(k));
    const auto picture = with_noise(with_shadow(wall, {80, 60}, {50, 30}, 0.6, 4), 8, std::uint64_t(k) + 100);
    const auto mask = mask_between(picture, wall);
    const auto before = mask.clone();
    const auto out = without_soft_light(mask, picture, wall);
    EXPECT_TRUE(same_bytes(mask, before));
    EXPECT_EQ(cv::countNonZero(out & ~mask), 0);
  }
}

TEST(WithoutSoftLight, AnEmptyMaskStaysEmpty) {
  const auto wall = textured_wall(kShadowSize);
  const cv::Mat empty = cv::Mat::zeros(kShadowSize, CV_8UC1);
  EXPECT_TRUE(same_bytes(without_soft_light(empty, wall, wall), empty));
}

TEST(WithoutSoftLight, AMaskThatTouchesAllBordersIsFollowedFromTheGapsInIt) {
  const auto wall = textured_wall(kShadowSize);
  const cv::Mat full(kShadowSize, CV_8UC1, cv::Scalar(255));
  // The whole picture is mask: there is no unchanged wall to come from.
  const auto dimmed = test::in_light(wall, 0.85);
  EXPECT_TRUE(same_bytes(without_soft_light(full, dimmed, wall), full));
  // A coloured frame along all borders stays.
  cv::Mat frame = full.clone();
  frame(cv::Rect(10, 10, 140, 100)) = 0;
  const auto picture = with_body(wall, frame, cv::Scalar(20, 20, 230));
  const auto mask = mask_between(picture, wall);
  EXPECT_TRUE(same_bytes(without_soft_light(mask, picture, wall), mask));
}

TEST(WithoutSoftLight, TinyPicturesAreFine) {
  for (const auto size : {cv::Size(1, 1), cv::Size(1, 7), cv::Size(7, 1), cv::Size(3, 3)}) {
    const cv::Mat wall(size, CV_8UC3, cv::Scalar(100, 100, 100));
    const cv::Mat picture(size, CV_8UC3, cv::Scalar(20, 20, 220));
    const cv::Mat full(size, CV_8UC1, cv::Scalar(255));
    EXPECT_TRUE(same_bytes(without_soft_light(full, picture, wall), full));
  }
}

// No channel tells it from a shadow, and each step is within what a shadow may have; but its outline is one all around.
TEST(WithoutSoftLight, PlainClothesOfTheWallsHueStay) {
  const auto wall = textured_wall(kShadowSize);
  const auto body = figure_mask(kShadowSize, {80, 60}, 100);
  auto picture = wall.clone();
  test::in_light(wall, 0.82).copyTo(picture, body);
  for (const double sigma : {0.0, 2.0}) {
    const auto noisy = with_noise(picture, sigma, 1);
    const auto mask = annealed(mask_between(noisy, wall), 1);
    EXPECT_GT(iou(without_soft_light(mask, noisy, wall), body), 0.95) << sigma;
  }
}

}  // namespace
}  // namespace choreo::vision
