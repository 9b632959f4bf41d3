// SPDX-License-Identifier: Apache-2.0
#include "vision/runs.hpp"

#include <map>
#include <random>
#include <set>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace choreo::vision {
namespace {

cv::Mat random_mask(cv::Size size, double share, std::mt19937& random) {
  cv::Mat mask(size, CV_8UC1);
  std::bernoulli_distribution set(share);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) mask.at<std::uint8_t>(y, x) = set(random) ? 255 : 0;
  }
  return mask;
}

TEST(Runs, PaintedTheyAreTheMaskAgain) {
  std::mt19937 random(1);
  for (int width = 1; width <= 19; ++width) {
    for (const double share : {0.0, 0.1, 0.5, 0.9, 1.0}) {
      const auto mask = random_mask({width, 5}, share, random);
      cv::Mat painted = cv::Mat::zeros(mask.size(), CV_8UC1);
      for (int y = 0; y < mask.rows; ++y) {
        int end = -1;
        for_each_run(mask.ptr<std::uint8_t>(y), mask.cols, [&](int from, int to) {
          EXPECT_GT(from, end) << "two runs with nothing between them";
          EXPECT_LT(from, to);
          end = to;
          painted(cv::Rect(from, y, to - from, 1)).setTo(255);
        });
      }
      EXPECT_EQ(cv::countNonZero(painted != mask), 0) << width << " " << share;
    }
  }
}

TEST(Runs, AreInOnePartWhereOpenCvGivesThemOneLabel) {
  std::mt19937 random(2);
  for (const auto neighbours : {Neighbours::kFour, Neighbours::kEight}) {
    for (const double share : {0.05, 0.35, 0.5, 0.6, 0.95}) {
      const auto mask = random_mask({37, 29}, share, random);
      const auto parts = parts_of(mask, neighbours);
      cv::Mat labels;
      const int count = cv::connectedComponents(mask, labels, neighbours == Neighbours::kFour ? 4 : 8, CV_32S);
      EXPECT_EQ(parts.count + 1, std::size_t(count));
      ASSERT_EQ(parts.runs.size(), parts.part_of.size());
      std::map<std::size_t, std::set<int>> labels_of;
      for (std::size_t k = 0; k < parts.runs.size(); ++k) {
        const auto& run = parts.runs[k];
        for (int x = run.from; x < run.to; ++x) labels_of[parts.part_of[k]].insert(labels.at<int>(run.y, x));
      }
      for (const auto& [part, of_part] : labels_of) {
        EXPECT_EQ(of_part.size(), 1U) << part;
        EXPECT_EQ(of_part.count(0), 0U) << part;
      }
      EXPECT_EQ(labels_of.size(), parts.count);
    }
  }
}

TEST(Runs, PartsAreNumberedInTheOrderOfTheirFirstPixels) {
  // The right arm of the first part begins later than the second part, and joins it only at the bottom.
  cv::Mat mask = cv::Mat::zeros(4, 9, CV_8UC1);
  mask(cv::Rect(0, 0, 1, 4)).setTo(255);
  mask(cv::Rect(4, 0, 1, 2)).setTo(255);
  mask(cv::Rect(8, 1, 1, 3)).setTo(255);
  mask(cv::Rect(0, 3, 9, 1)).setTo(255);
  const auto parts = parts_of(mask, Neighbours::kEight);
  EXPECT_EQ(parts.count, 2U);
  ASSERT_GE(parts.runs.size(), 3U);
  EXPECT_EQ(parts.part_of[0], 0U);
  EXPECT_EQ(parts.part_of[1], 1U);
  EXPECT_EQ(parts.part_of.back(), 0U);
}

TEST(Runs, ACornerJoinsEightNeighboursAndNotFour) {
  cv::Mat mask = cv::Mat::zeros(2, 2, CV_8UC1);
  mask.at<std::uint8_t>(0, 0) = mask.at<std::uint8_t>(1, 1) = 255;
  EXPECT_EQ(parts_of(mask, Neighbours::kEight).count, 1U);
  EXPECT_EQ(parts_of(mask, Neighbours::kFour).count, 2U);
  cv::flip(mask, mask, 1);
  EXPECT_EQ(parts_of(mask, Neighbours::kEight).count, 1U);
  EXPECT_EQ(parts_of(mask, Neighbours::kFour).count, 2U);
}

TEST(Runs, AnEmptyMaskHasNone) {
  EXPECT_EQ(parts_of(cv::Mat::zeros(3, 3, CV_8UC1), Neighbours::kFour).count, 0U);
  EXPECT_TRUE(parts_of(cv::Mat(), Neighbours::kEight).runs.empty());
}

}  // namespace
}  // namespace choreo::vision
