// SPDX-License-Identifier: Apache-2.0
// MATH.md section 2, from picture to mask, on pictures small enough to be worked by hand.
#include "vision/difference.hpp"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "support/drawn_masks.hpp"

namespace choreo::vision {
namespace {

using test::mask_of;
using test::random_mask;
using test::same_bytes;

int luminance_of(cv::Vec3b picture, cv::Vec3b background) {
  return difference_luminance(cv::Mat(1, 1, CV_8UC3, picture), cv::Mat(1, 1, CV_8UC3, background)).at<uchar>(0, 0);
}

TEST(DifferenceLuminance, WeighsTheDifferencesOfRedGreenAndBlue) {
  EXPECT_EQ(luminance_of({10, 20, 30}, {10, 20, 30}), 0);
  EXPECT_EQ(luminance_of({0, 0, 100}, {0, 0, 0}), 30);  // 29.9
  EXPECT_EQ(luminance_of({0, 100, 0}, {0, 0, 0}), 59);  // 58.7
  EXPECT_EQ(luminance_of({100, 0, 0}, {0, 0, 0}), 11);  // 11.4
  EXPECT_EQ(luminance_of({0, 0, 0}, {100, 100, 100}), 100);
  EXPECT_EQ(luminance_of({255, 255, 255}, {0, 0, 0}), 255);
}

TEST(DifferenceLuminance, SeesRedBeforeGreenOfEqualBrightness) {
  // 0.299 * 196 = 58.6 = 0.587 * 100 (58.7): equally bright, and yet D is their sum.
  EXPECT_EQ(luminance_of({0, 0, 196}, {0, 100, 0}), 117);
}

TEST(DifferenceLuminance, DoesNotCareWhichIsWhich) {
  EXPECT_EQ(luminance_of({5, 200, 90}, {80, 10, 250}), luminance_of({80, 10, 250}, {5, 200, 90}));
}

TEST(Annealed, NoStepsLeaveTheMaskAsItIs) {
  const auto mask = mask_of({"#.#", "...", "#.#"});
  EXPECT_TRUE(same_bytes(annealed(mask, 0), mask));
}

TEST(Annealed, ClosesGapsOfTwiceTheStepsAndNoWiderOnes) {
  for (int n = 1; n <= 4; ++n) {
    for (const int gap : {2 * n, 2 * n + 1}) {
      cv::Mat mask(30, 60, CV_8UC1, cv::Scalar(255));
      mask(cv::Rect(25, 0, gap, 30)) = 0;
      const auto out = annealed(mask, n);
      EXPECT_EQ(cv::countNonZero(out), gap == 2 * n ? 60 * 30 : (60 - gap) * 30) << n << " steps, gap " << gap;
    }
  }
}

TEST(Annealed, WorksInTheEightNeighbourhood) {
  // Four corners of a square: grown by one they cover five by five pixels, which shrink to the whole square. Grown
  // along rows and columns alone they would leave its middle out.
  EXPECT_TRUE(
      same_bytes(annealed(mask_of({".......", ".......", "..#.#..", ".......", "..#.#..", ".......", "......."}), 1),
                 mask_of({".......", ".......", "..###..", "..###..", "..###..", ".......", "......."})));
}

TEST(Annealed, WhatLiesOutsideThePictureNeitherGrowsInNorEatsAway) {
  // A body that fills the picture stays; a lone pixel in a corner stays alone.
  const cv::Mat full(4, 6, CV_8UC1, cv::Scalar(255));
  EXPECT_TRUE(same_bytes(annealed(full, 3), full));
  const auto corner = mask_of({"#.....", "......", "......", "......", "......"});
  EXPECT_TRUE(same_bytes(annealed(corner, 1), corner));
  // A gap of one column beside the border is closed by one step, one of two columns is not.
  EXPECT_TRUE(same_bytes(annealed(mask_of({".####", ".####", ".####"}), 1), mask_of({"#####", "#####", "#####"})));
  EXPECT_TRUE(same_bytes(annealed(mask_of({"..###", "..###", "..###"}), 1), mask_of({"..###", "..###", "..###"})));
}

TEST(Annealed, RepeatingItChangesNothingAndNoPixelIsEverLost) {
  std::mt19937 random(1);
  for (int k = 0; k < 30; ++k) {
    const auto mask = random_mask(random, {1 + 3 * k % 40, 1 + 7 * k % 30}, 0.02 + 0.02 * k);
    for (const int n : {1, 2, 5}) {
      const auto once = annealed(mask, n);
      EXPECT_TRUE(same_bytes(annealed(once, n), once)) << mask.size() << " " << n;
      EXPECT_EQ(cv::countNonZero(mask & ~once), 0);
    }
  }
}

TEST(Annealed, OneClosingOfTwoStepsIsNotTwoOfOne) {
  const auto mask = mask_of({"#####...######", "#####...######", "#####...######"});
  EXPECT_TRUE(same_bytes(annealed(annealed(mask, 1), 1), mask));
  EXPECT_EQ(cv::countNonZero(annealed(mask, 2)), 14 * 3);
}

TEST(Annealed, APartOfALargerPictureIsAPictureOfItsOwn) {
  cv::Mat large(20, 20, CV_8UC1, cv::Scalar(255));
  large(cv::Rect(6, 6, 8, 8)) = 0;
  large.at<uchar>(9, 9) = 255;
  const cv::Mat part = large(cv::Rect(6, 6, 8, 8));
  EXPECT_TRUE(same_bytes(annealed(part, 2), annealed(part.clone(), 2)));
  EXPECT_TRUE(same_bytes(edge_at_half_contrast(part, part), edge_at_half_contrast(part.clone(), part.clone())));
}

TEST(EdgeAtHalfContrast, KeepsEdgePixelsThatDifferAtLeastHalfAsMuchAsTheBodyBesideThem) {
  const auto mask = mask_of({"..#####.."});
  const cv::Mat difference = (cv::Mat_<uchar>(1, 9) << 0, 0, 49, 100, 100, 100, 50, 0, 0);
  EXPECT_TRUE(same_bytes(edge_at_half_contrast(mask, difference), mask_of({"...####.."})));
}

TEST(EdgeAtHalfContrast, LeavesTheInsideAloneHoweverFaint) {
  cv::Mat mask = cv::Mat::zeros(7, 7, CV_8UC1);
  mask(cv::Rect(1, 1, 5, 5)) = 255;
  cv::Mat difference(7, 7, CV_8UC1, cv::Scalar(200));
  difference.at<uchar>(3, 3) = 1;
  EXPECT_TRUE(same_bytes(edge_at_half_contrast(mask, difference), mask));
}

TEST(EdgeAtHalfContrast, ABodyCutByTheFrameHasNoEdgeThere) {
  const cv::Mat full(3, 4, CV_8UC1, cv::Scalar(255));
  cv::Mat difference(3, 4, CV_8UC1, cv::Scalar(200));
  difference.col(0) = 20;
  EXPECT_TRUE(same_bytes(edge_at_half_contrast(full, difference), full));
}

TEST(EdgeAtHalfContrast, WhatDiffersOutsideTheMaskDoesNotCount) {
  const auto mask = mask_of({".##."});
  const cv::Mat difference = (cv::Mat_<uchar>(1, 4) << 250, 20, 20, 250);
  EXPECT_TRUE(same_bytes(edge_at_half_contrast(mask, difference), mask));
}

TEST(WithoutSpecks, TakesComponentsBelowTheAreaAndKeepsThoseAtIt) {
  const auto mask = mask_of({"##...#", "##....", "....##", ".....#"});
  EXPECT_TRUE(same_bytes(without_specks(mask, 4, false), mask_of({"##....", "##....", "......", "......"})));
  EXPECT_TRUE(same_bytes(without_specks(mask, 3, false), mask_of({"##....", "##....", "....##", ".....#"})));
  EXPECT_TRUE(same_bytes(without_specks(mask, 1, false), mask));
  EXPECT_TRUE(same_bytes(without_specks(mask, 0, false), mask));
  EXPECT_EQ(cv::countNonZero(without_specks(mask, 5, false)), 0);
}

TEST(ClosedByDisc, DoneAroundTheMaskAloneIsDoneEverywhere) {
  const auto everywhere = [](const cv::Mat& mask, double radius) {
    cv::Mat distance;
    cv::distanceTransform(~mask, distance, cv::DIST_L2, 3);
    const cv::Mat grown = distance <= radius;
    cv::distanceTransform(grown, distance, cv::DIST_L2, 3);
    return cv::Mat(distance > radius - 2.0);
  };
  const cv::Size size(61, 47);
  const std::vector<cv::Rect> bodies = {{20, 15, 12, 20}, {0, 10, 9, 14}, {52, 10, 9, 14}, {24, 0, 10, 9},
                                        {24, 38, 10, 9},  {0, 0, 7, 7},   {54, 40, 7, 7},  {0, 0, 61, 47},
                                        {30, 0, 1, 47},   {0, 22, 61, 1}, {1, 1, 59, 45},  {17, 17, 1, 1}};
  std::mt19937 random(4);
  for (const double radius : {2.0, 2.5, 3 * 0.955, 5 * 0.955 - 1e-6, 7.3, 11.0, 40.0, 200.0}) {
    for (const auto& body : bodies) {
      cv::Mat mask = cv::Mat::zeros(size, CV_8UC1);
      mask(body) = 255;
      EXPECT_TRUE(same_bytes(closed_by_disc(mask, radius), everywhere(mask, radius))) << body << " " << radius;
    }
    for (const double share : {0.0, 0.001, 0.01, 0.2}) {
      const auto mask = random_mask(random, size, share);
      EXPECT_TRUE(same_bytes(closed_by_disc(mask, radius), everywhere(mask, radius))) << share << " " << radius;
    }
  }
}

TEST(ClosedByDisc, ClosesGapsAndStandsOutByTwoPixels) {
  const auto mask = mask_of({"...........", "...........", "...#...#...", "...........", "..........."});
  const auto closed = closed_by_disc(mask, 2.0);
  EXPECT_EQ(closed.at<uchar>(2, 5), 255) << "the gap of three between them";
  EXPECT_EQ(closed.at<uchar>(2, 1), 255) << "two to the side";
  EXPECT_EQ(closed.at<uchar>(2, 0), 0);
}

TEST(WithoutSpecks, DiagonalNeighboursAreOneComponent) {
  const auto mask = mask_of({"#...", ".#..", "..#.", "...#"});
  EXPECT_TRUE(same_bytes(without_specks(mask, 4, false), mask));
}

TEST(WithoutSpecks, TheLargestIsTheFirstInReadingOrderAmongEquals) {
  EXPECT_TRUE(same_bytes(without_specks(mask_of({"#..##", "#....", "...##", "..##."}), 0, true),
                         mask_of({".....", ".....", "...##", "..##."})));
  EXPECT_TRUE(same_bytes(without_specks(mask_of({"...##.", "##....", ".....#", ".....#"}), 0, true),
                         mask_of({"...##.", "......", "......", "......"})));
}

TEST(WithoutSpecks, TheLargestGoesTooWhereItIsASpeck) {
  EXPECT_EQ(cv::countNonZero(without_specks(mask_of({"##..#"}), 3, true)), 0);
}

TEST(WithoutSpecks, EmptyAndFullAndTinyMasksAreFine) {
  for (const auto size : {cv::Size(1, 1), cv::Size(1, 9), cv::Size(9, 1), cv::Size(2, 2), cv::Size(50, 40)}) {
    const cv::Mat empty = cv::Mat::zeros(size, CV_8UC1);
    const cv::Mat full(size, CV_8UC1, cv::Scalar(255));
    for (const bool largest : {false, true}) {
      EXPECT_TRUE(same_bytes(without_specks(empty, 1, largest), empty));
      EXPECT_TRUE(same_bytes(without_specks(full, size.area(), largest), full));
      EXPECT_TRUE(same_bytes(without_specks(full, size.area() + 1, largest), empty));
    }
  }
}

TEST(WithoutSpecks, DoesNotChangeItsInput) {
  const auto mask = mask_of({"##.#"});
  const auto copy = mask.clone();
  cv::Mat out = without_specks(mask, 1, false);
  out = 0;
  EXPECT_TRUE(same_bytes(mask, copy));
}

TEST(WithoutSmallHoles, AHoleOfThatManyPixelsIsFilledAndALargerOneStays) {
  const auto mask = mask_of({"########",  //
                             "#.##...#",  //
                             "#.##...#",  //
                             "########"});
  EXPECT_TRUE(same_bytes(without_small_holes(mask, 2), mask_of({"########",  //
                                                                "####...#",  //
                                                                "####...#",  //
                                                                "########"})));
  EXPECT_TRUE(same_bytes(without_small_holes(mask, 1), mask));
  EXPECT_EQ(cv::countNonZero(~without_small_holes(mask, 6)), 0);
}

TEST(WithoutSmallHoles, WhatTouchesTheBorderIsNoHole) {
  const auto bay = mask_of({"##.##",  //
                            "##.##",  //
                            "#####"});
  EXPECT_TRUE(same_bytes(without_small_holes(bay, 100), bay));
}

TEST(WithoutSmallHoles, PartsThatMeetAtACornerOnlyAreTwoHoles) {
  const auto mask = mask_of({"####",  //
                             "#.##",  //
                             "##.#",  //
                             "####"});
  EXPECT_EQ(cv::countNonZero(~without_small_holes(mask, 1)), 0);
}

TEST(WithoutSmallHoles, EmptyAndFullMasksStay) {
  const cv::Mat empty = cv::Mat::zeros(5, 7, CV_8UC1);
  const cv::Mat full(5, 7, CV_8UC1, cv::Scalar(255));
  EXPECT_TRUE(same_bytes(without_small_holes(empty, 99), empty));
  EXPECT_TRUE(same_bytes(without_small_holes(full, 99), full));
}

}  // namespace
}  // namespace choreo::vision
