// SPDX-License-Identifier: Apache-2.0
// Regions and moments: worked by hand, against the plain double sum, and by the identities of MATH.md section 3.
#include "vision/blobs.hpp"

#include <cmath>
#include <map>
#include <random>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "support/drawn_masks.hpp"

namespace choreo::vision {
namespace {

using test::mask_of;
using test::random_mask;

// The definition: mean first, then the sum over pixels.
Moments plain_sum(const cv::Mat& mask) {
  Moments m;
  long double sx = 0;
  long double sy = 0;
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) {
      if (mask.at<uchar>(y, x) == 0) continue;
      m.m00 += 1;
      sx += x;
      sy += y;
    }
  }
  m.centroid = {double(sx / m.m00), double(sy / m.m00)};
  long double sums[4][4] = {};
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) {
      if (mask.at<uchar>(y, x) == 0) continue;
      for (int p = 0; p < 4; ++p) {
        for (int q = 0; q < 4; ++q) sums[p][q] += std::pow(x - sx / m.m00, p) * std::pow(y - sy / m.m00, q);
      }
    }
  }
  m.mu20 = double(sums[2][0]);
  m.mu11 = double(sums[1][1]);
  m.mu02 = double(sums[0][2]);
  m.mu30 = double(sums[3][0]);
  m.mu21 = double(sums[2][1]);
  m.mu12 = double(sums[1][2]);
  m.mu03 = double(sums[0][3]);
  return m;
}

void expect_near(const Moments& a, const Moments& b, double relative) {
  EXPECT_EQ(a.m00, b.m00);
  EXPECT_NEAR(a.centroid.x, b.centroid.x, 1e-11);
  EXPECT_NEAR(a.centroid.y, b.centroid.y, 1e-11);
  const double second = std::abs(b.mu20) + std::abs(b.mu02) + 1;
  EXPECT_NEAR(a.mu20, b.mu20, relative * second);
  EXPECT_NEAR(a.mu11, b.mu11, relative * second);
  EXPECT_NEAR(a.mu02, b.mu02, relative * second);
  const double third = std::pow(second, 1.5);
  EXPECT_NEAR(a.mu30, b.mu30, relative * third);
  EXPECT_NEAR(a.mu21, b.mu21, relative * third);
  EXPECT_NEAR(a.mu12, b.mu12, relative * third);
  EXPECT_NEAR(a.mu03, b.mu03, relative * third);
}

// Of all pixels that are set. (cv::boundingRect of OpenCV 4.6 can lose the second column of a mask.)
cv::Rect plain_box(const cv::Mat& mask) {
  cv::Rect box;
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) {
      if (mask.at<uchar>(y, x) != 0) box |= cv::Rect(x, y, 1, 1);
    }
  }
  return box;
}

cv::Mat shifted(const cv::Mat& mask, cv::Size size, cv::Point step) {
  cv::Mat out = cv::Mat::zeros(size, CV_8UC1);
  mask.copyTo(out(cv::Rect(step, mask.size())));
  return out;
}

TEST(Moments, OfAnElWorkedByHand) {
  // Pixels (0,0), (0,1), (0,2), (3,2): centroid (3/4, 5/4).
  const auto m = moments_of(mask_of({"#...", "#...", "#..#"}));
  EXPECT_EQ(m.m00, 4);
  EXPECT_EQ(m.centroid, cv::Point2d(0.75, 1.25));
  EXPECT_DOUBLE_EQ(m.mu20, 6.75);    // 3 (3/4)^2 + (9/4)^2
  EXPECT_DOUBLE_EQ(m.mu11, 2.25);    // -3/4 (-5/4 - 1/4 + 3/4) + 9/4 3/4
  EXPECT_DOUBLE_EQ(m.mu02, 2.75);    // (25 + 1 + 9 + 9) / 16
  EXPECT_DOUBLE_EQ(m.mu30, 10.125);  // -3 (3/4)^3 + (9/4)^3
  EXPECT_DOUBLE_EQ(m.mu21, 3.375);   // 9/16 (-5/4 - 1/4 + 3/4) + 81/16 3/4
  EXPECT_DOUBLE_EQ(m.mu12, -0.375);  // -3/4 (25 + 1 + 9)/16 + 9/4 9/16
  EXPECT_DOUBLE_EQ(m.mu03, -1.125);  // (-125 - 1 + 27 + 27) / 64
}

TEST(Moments, OfARectangleAreItsTextbookOnes) {
  // n points a unit apart: (n^2 - 1) / 12 each.
  const cv::Mat rectangle(5, 8, CV_8UC1, cv::Scalar(1));
  const auto m = moments_of(rectangle);
  EXPECT_DOUBLE_EQ(m.mu20, 40 * 63.0 / 12);
  EXPECT_DOUBLE_EQ(m.mu02, 40 * 24.0 / 12);
  for (const double zero : {m.mu11, m.mu30, m.mu21, m.mu12, m.mu03}) EXPECT_EQ(zero, 0);
}

TEST(Moments, EqualThePlainDoubleSum) {
  std::mt19937 random(1);
  for (int k = 0; k < 40; ++k) {
    const auto mask = random_mask(random, {1 + 7 * k % 61, 1 + 5 * k % 43}, 0.05 + 0.02 * k);
    expect_near(moments_of(mask), plain_sum(mask), 1e-13);
  }
}

TEST(Moments, AgreeWithOpenCv) {
  std::mt19937 random(2);
  for (int k = 0; k < 20; ++k) {
    const auto mask = random_mask(random, {40 + k, 30 + 2 * k}, 0.1 + 0.04 * k);
    const auto peer = cv::moments(mask, true);
    Moments m;
    m.m00 = peer.m00;
    m.centroid = {peer.m10 / peer.m00, peer.m01 / peer.m00};
    m.mu20 = peer.mu20, m.mu11 = peer.mu11, m.mu02 = peer.mu02;
    m.mu30 = peer.mu30, m.mu21 = peer.mu21, m.mu12 = peer.mu12, m.mu03 = peer.mu03;
    expect_near(moments_of(mask), m, 1e-9);
  }
}

TEST(Moments, KeepTheirDigitsFarFromTheOrigin) {
  // The plain raw sums lose all but four digits of a third moment there.
  std::mt19937 random(3);
  const auto mask = random_mask(random, {9, 7}, 0.4);
  const auto near = moments_of(mask);
  const auto far = moments_of(shifted(mask, {kLongestSide, 2160}, {kLongestSide - 9, 2160 - 7}));
  EXPECT_EQ(far.mu20, near.mu20);
  EXPECT_EQ(far.mu11, near.mu11);
  EXPECT_EQ(far.mu02, near.mu02);
  EXPECT_EQ(far.mu30, near.mu30);
  EXPECT_EQ(far.mu21, near.mu21);
  EXPECT_EQ(far.mu12, near.mu12);
  EXPECT_EQ(far.mu03, near.mu03);
}

TEST(Moments, OfTheLargestPictureDoNotOverflow) {
  RawMoments sums;
  for (int y = 0; y < kLongestSide; ++y) sums.add({y, 0, kLongestSide});
  const auto m = sums.central();
  const double n = kLongestSide;
  EXPECT_DOUBLE_EQ(m.mu20, n * n * (n * n - 1) / 12);
  EXPECT_DOUBLE_EQ(m.mu02, n * n * (n * n - 1) / 12);
  EXPECT_NEAR(m.mu30 / m.mu20, 0, 1e-9);
  EXPECT_NEAR(m.mu12 / m.mu20, 0, 1e-9);
}

TEST(Moments, OfNothingAreNothing) {
  EXPECT_EQ(moments_of(cv::Mat::zeros(4, 4, CV_8UC1)).m00, 0);
  EXPECT_EQ(moments_of(cv::Mat()).m00, 0);
}

TEST(Moments, OfTwoRegionsTogetherAreThoseOfTheirUnion) {
  std::mt19937 random(4);
  for (int k = 0; k < 20; ++k) {
    const cv::Size size(200, 100);
    const auto one = shifted(random_mask(random, {20 + k, 10}, 0.3), size, {3, 5 * k % 80});
    const auto other = shifted(random_mask(random, {10, 15 + k}, 0.6), size, {100 + 4 * k, 40});
    expect_near(together(moments_of(one), moments_of(other)), plain_sum(one | other), 1e-12);
  }
  const auto alone = moments_of(mask_of({"##", "#."}));
  expect_near(together(alone, {}), alone, 0);
  expect_near(together({}, alone), alone, 0);
}

TEST(Moments, OfTwoBlobsKeepTheSquareOfTheirDistance) {
  // The thesis drops the square: mu20 = mu20' + mu20'' + 2 a^2, all per unit area.
  const auto one = moments_of(mask_of({"##", "##", "#."}));
  auto other = one;
  other.centroid += cv::Point2d(14, -6);
  const auto both = together(one, other);
  const double unit = one.m00;
  EXPECT_NEAR(both.mu20 / unit, 2 * one.mu20 / unit + 2 * 7 * 7, 1e-12);
  EXPECT_NEAR(both.mu02 / unit, 2 * one.mu02 / unit + 2 * 3 * 3, 1e-12);
  EXPECT_NEAR(both.mu11 / unit, 2 * one.mu11 / unit - 2 * 7 * 3, 1e-12);
}

TEST(Moments, ThirdOrderIdentitiesHoldForEqualBlobsWithoutThirdMoments) {
  // One bar level, one upright, equal areas and traces, no third moments; at +-(a, b).
  const double a = 40;
  const double b = 25;
  Moments one;
  one.m00 = 1;
  one.mu20 = 90, one.mu02 = 10, one.mu11 = -7;
  auto other = one;
  other.mu20 = 35, other.mu02 = 65, other.mu11 = 21;
  one.centroid = {a, b};
  other.centroid = {-a, -b};
  const auto both = together(one, other);
  const auto c = [](const Moments& m) { return cv::Point2d((m.mu20 - m.mu02) / 2, m.mu11); };
  const auto d = c(one) - c(other);
  EXPECT_NEAR(both.mu30, 3 * a * d.x, 1e-9);
  EXPECT_NEAR(both.mu03, -3 * b * d.x, 1e-9);
  EXPECT_NEAR(both.mu21, 2 * a * d.y + b * d.x, 1e-9);
  EXPECT_NEAR(both.mu12, 2 * b * d.y - a * d.x, 1e-9);
}

TEST(Moments, ThirdOrderIdentitiesHoldInPixels) {
  const cv::Mat level(3, 9, CV_8UC1, cv::Scalar(1));
  cv::Mat picture = cv::Mat::zeros(60, 80, CV_8UC1);
  level.copyTo(picture(cv::Rect(50, 40, 9, 3)));
  cv::Mat upright = level.t();
  upright.copyTo(picture(cv::Rect(10, 8, 3, 9)));
  const auto both = moments_of(picture);
  // Centroids (54, 41) and (11, 12): a = 21.5, b = 14.5; 27 pixels each; c = +-27 (80 - 8) / 24 along x.
  const double d = 2 * 27 * (80.0 - 8.0) / 24;
  EXPECT_NEAR(both.mu30, 3 * 21.5 * d, 1e-8);
  EXPECT_NEAR(both.mu03, -3 * 14.5 * d, 1e-8);
  EXPECT_NEAR(both.mu21, 14.5 * d, 1e-8);
  EXPECT_NEAR(both.mu12, -21.5 * d, 1e-8);
}

TEST(Regions, AreNumberedInReadingOrderWithTheirBoxes) {
  const auto regions = regions_of(mask_of({"..#...##",  //
                                           "........",  //
                                           "###..#..",  //
                                           "#....##."}));
  ASSERT_EQ(regions.blobs.size(), 4U);
  EXPECT_EQ(regions.blobs[0].box, cv::Rect(2, 0, 1, 1));
  EXPECT_EQ(regions.blobs[1].box, cv::Rect(6, 0, 2, 1));
  EXPECT_EQ(regions.blobs[2].box, cv::Rect(0, 2, 3, 2));
  EXPECT_EQ(regions.blobs[3].box, cv::Rect(5, 2, 2, 2));
  EXPECT_EQ(regions.blobs[2].moments.m00, 4);
  EXPECT_EQ(regions.blobs[2].moments.centroid, cv::Point2d(0.75, 2.25));
}

TEST(Regions, TouchAtCornersAndAroundBends) {
  EXPECT_EQ(regions_of(mask_of({"#.#", ".#.", "#.#"})).blobs.size(), 1U);
  EXPECT_EQ(regions_of(mask_of({"#.#.#", "#.#.#", "#####"})).blobs.size(), 1U);
  EXPECT_EQ(regions_of(mask_of({"#####", "#...#", "#.#.#", "#...#", "#####"})).blobs.size(), 2U);
  EXPECT_EQ(regions_of(mask_of({"#..#", "....", "#..#"})).blobs.size(), 4U);
}

TEST(Regions, SmallerThanTheLeastAreaAreLeftOut) {
  const auto mask = mask_of({"##.#", "....", "###."});
  EXPECT_EQ(regions_of(mask, 1).blobs.size(), 3U);
  EXPECT_EQ(regions_of(mask, 2).blobs.size(), 2U);
  EXPECT_EQ(regions_of(mask, 3).blobs.size(), 1U);
  EXPECT_EQ(regions_of(mask, 4).blobs.size(), 0U);
}

TEST(Regions, OfNothingAreNoneAndOfEverythingOne) {
  EXPECT_TRUE(regions_of(cv::Mat()).blobs.empty());
  EXPECT_TRUE(regions_of(cv::Mat::zeros(3, 5, CV_8UC1)).blobs.empty());
  const auto all = regions_of(cv::Mat(17, 31, CV_8UC1, cv::Scalar(255)));
  ASSERT_EQ(all.blobs.size(), 1U);
  EXPECT_EQ(all.blobs[0].box, cv::Rect(0, 0, 31, 17));
  EXPECT_EQ(all.blobs[0].moments.m00, 31 * 17);
}

TEST(Regions, AreThoseOfOpenCvWithTheMomentsOfEach) {
  std::mt19937 random(5);
  for (int k = 0; k < 30; ++k) {
    const auto mask = random_mask(random, {1 + 11 * k % 90, 1 + 13 * k % 70}, 0.02 * k + 0.1);
    const auto regions = regions_of(mask);
    cv::Mat labels;
    const int count = cv::connectedComponents(mask, labels, 8, CV_32S);
    ASSERT_EQ(int(regions.blobs.size()), count - 1);
    cv::Mat painted = cv::Mat::zeros(mask.size(), CV_8UC1);
    for (std::size_t n = 0; n < regions.blobs.size(); ++n) {
      const auto& first = regions.runs[n].front();
      const cv::Mat own = labels == labels.at<int>(first.y, first.from);
      const auto& blob = regions.blobs[n];
      expect_near(blob.moments, plain_sum(own), 1e-13);
      EXPECT_EQ(blob.box, plain_box(own));
      paint(regions.runs[n], 255, painted);
    }
    EXPECT_TRUE(test::same_bytes(painted, mask));
  }
}

}  // namespace
}  // namespace choreo::vision
