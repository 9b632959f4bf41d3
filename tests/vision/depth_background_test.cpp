// SPDX-License-Identifier: Apache-2.0
// The room's depth from few readings by hand, and behind a body that never leaves.
#include "vision/depth_background.hpp"

#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <opencv2/imgproc.hpp>

#include "support/frames.hpp"

namespace choreo::vision {
namespace {

using test::same_pixels;

/// One pixel's readings as so many pictures of 1 x 1.
DepthBackground of_readings(const std::vector<int>& readings) {
  std::vector<cv::Mat> pictures;
  for (const int z : readings) pictures.emplace_back(1, 1, CV_16UC1, cv::Scalar(z));
  return learn_depth_background(pictures);
}
int depth_of(const std::vector<int>& readings) { return of_readings(readings).depth_mm.at<ushort>(0, 0); }

std::vector<int> times(std::size_t count, int z) { return std::vector<int>(count, z); }
std::vector<int> operator+(std::vector<int> a, const std::vector<int>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(DepthBackground, IsTheMedianOfTheValidReadings) {
  EXPECT_EQ(depth_of({2010, 1990, 2000, 1995, 2020}), 2000);
  EXPECT_EQ(depth_of({0, 2000, 0, 0, 2010, 1990, 0}), 2000) << "0 is no reading";
  EXPECT_EQ(depth_of({2000}), 2000);
}

TEST(DepthBackground, WhereFewerThanATwentiethAreValidNothingIsKnown) {
  EXPECT_EQ(depth_of(times(10, 0)), 0);
  EXPECT_EQ(depth_of(times(39, 0) + times(1, 2000)), 0) << "1 of 40, and 2 would do";
  EXPECT_EQ(depth_of(times(38, 0) + times(2, 2000)), 2000);
}

TEST(DepthBackground, ABodyIsOnlyNearerSoTheFarthestDepthSeenOftenEnoughIsTheRoom) {
  EXPECT_EQ(depth_of(times(90, 2500) + times(10, 3500)), 3500) << "covered nine tenths of the time";
  EXPECT_EQ(depth_of(times(50, 2500) + times(25, 3000) + times(25, 3500)), 3500);
  EXPECT_EQ(depth_of(times(97, 2500) + times(3, 3500)), 2500) << "less than a twentieth is an error";
  // 3500 mm has gaps of up to 73 mm within a run: 3430 and 3500 are one depth, 3400 and 3500 are two.
  EXPECT_EQ(depth_of({3430, 3430, 3430, 3500}), 3430);
  EXPECT_EQ(depth_of({3400, 3400, 3400, 3500}), 3500);
}

TEST(DepthBackground, WhereNoDepthIsSeenOftenEnoughTheCommonestIsTaken) {
  std::vector<int> readings = times(37, 0) + times(1, 1000) + times(1, 2000);
  readings.push_back(3000);
  EXPECT_EQ(depth_of(readings), 3000) << "of equals the farthest";
  EXPECT_EQ(depth_of(times(56, 0) + std::vector<int>{1000, 1001, 2000, 3000}), 1001);
}

TEST(DepthBackground, TheSpreadIsTheDeviationOfTheRoomsReadingsAlone) {
  const auto room = of_readings({2990, 3010, 2990, 3010, 2000, 2000});
  EXPECT_NEAR(room.spread_mm.at<float>(0, 0), 10.0F, 1e-3);
}

TEST(DepthBackground, ASpreadThatChanceMadeSmallIsTheSensorsOwnAtThatDepth) {
  // Three pixels deviate by 4 mm at 2 m: 1e-6 z^2. The fourth, at 4 m, happens to read the same each time.
  std::vector<cv::Mat> pictures;
  for (int i = 0; i < 10; ++i) {
    const int z = i % 2 == 0 ? 1996 : 2004;
    pictures.push_back((cv::Mat1w(1, 4) << z, z, z, 4000));
  }
  const auto room = learn_depth_background(pictures);
  EXPECT_NEAR(room.noise_per_mm, 1e-6, 1e-8);
  EXPECT_NEAR(room.spread_mm.at<float>(0, 3), 16.0F, 0.2);
  EXPECT_NEAR(room.spread_mm.at<float>(0, 0), 4.0F, 0.05);
}

TEST(DepthBackground, TheMarginIsAFactorOfTheSpreadAndNeverLessThanItsLeast) {
  const DepthMargin margin{4, 25};
  EXPECT_EQ(margin.of(0), 25);
  EXPECT_EQ(margin.of(10), 40);
}

// A wall at 3 m, a trunk at 2 m that never moves, an arm beside it that is up or down, and a table at 2.5 m.
const cv::Size kDepthRoomSize{96, 64};
const cv::Rect kTrunk{40, 16, 16, 40};
const cv::Rect kTable{76, 30, 12, 26};

cv::Mat rehearsal(int i, bool somebody = true) {
  cv::Mat depth(kDepthRoomSize, CV_16UC1, cv::Scalar(3000));
  depth(kTable) = 2500;
  if (!somebody) return depth;
  depth(kTrunk) = 2000;
  const int y = i % 3 == 0 ? 18 : i % 3 == 1 ? 28 : 38;
  depth(cv::Rect(26, y, 14, 6)) = 1980;
  return depth;
}

TEST(DepthBackground, BehindABodyThatNeverLeavesIsWhatIsBesideIt) {
  std::vector<cv::Mat> pictures;
  for (int i = 0; i < 30; ++i) pictures.push_back(rehearsal(i));
  const auto room = learn_depth_background(pictures);
  EXPECT_EQ(room.empty, 0.0);
  EXPECT_EQ(cv::boundingRect(room.inferred), kTrunk);
  EXPECT_EQ(cv::countNonZero(room.inferred), kTrunk.area());
  EXPECT_EQ(cv::countNonZero(room.depth_mm(kTrunk) != 3000), 0);
  EXPECT_EQ(cv::countNonZero(room.depth_mm(kTable) != 2500), 0) << "nothing that moves goes on in the table";
}

TEST(DepthBackground, ARoomThatWasSeenIsNotInferred) {
  std::vector<cv::Mat> pictures;
  for (int i = 0; i < 30; ++i) pictures.push_back(rehearsal(i, i % 2 == 0));
  const auto room = learn_depth_background(pictures);
  EXPECT_EQ(room.empty, 0.5);
  EXPECT_TRUE(room.inferred.empty());
  EXPECT_TRUE(same_pixels(room.depth_mm, rehearsal(0, false)));
}

TEST(DepthBackground, ATableThatIsTouchedNowAndThenStaysWhenItsUserLeaves) {
  std::vector<cv::Mat> pictures;
  for (int i = 0; i < 30; ++i) {
    auto depth = rehearsal(i, false);
    // Absent one time in three; else here or there, and one time in three leaning on the table.
    if (i % 3 == 1) depth(cv::Rect(8, 10, 12, 40)) = 2000;
    if (i % 3 == 2) depth(cv::Rect(64, 20, 12, 36)) = 2480;
    pictures.push_back(depth);
  }
  const auto room = learn_depth_background(pictures);
  EXPECT_TRUE(room.inferred.empty());
  EXPECT_TRUE(same_pixels(room.depth_mm, rehearsal(0, false)));
}

TEST(DepthBackground, IsTheSameInAMirrorAndWithAnyNumberOfThreads) {
  std::vector<cv::Mat> pictures, flipped;
  for (int i = 0; i < 30; ++i) {
    cv::Mat noisy = rehearsal(i) + test::noise(kDepthRoomSize, CV_16UC1, static_cast<std::uint64_t>(i)) / 64;
    pictures.push_back(noisy);
    flipped.emplace_back();
    cv::flip(noisy, flipped.back(), 1);
  }
  const auto room = learn_depth_background(pictures);
  const auto mirrored = learn_depth_background(flipped);
  cv::Mat back;
  cv::flip(mirrored.depth_mm, back, 1);
  EXPECT_TRUE(same_pixels(back, room.depth_mm));
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_TRUE(same_pixels(learn_depth_background(pictures).depth_mm, room.depth_mm));
}

TEST(DepthBackground, SaysHowMuchOfTheRoomIsKnownAndInferred) {
  cv::Mat depth(4, 10, CV_16UC1, cv::Scalar(2000));
  depth.col(0) = 0;
  const auto room = learn_depth_background(std::vector<cv::Mat>{depth});
  EXPECT_DOUBLE_EQ(room.known_share(), 0.9);
  EXPECT_DOUBLE_EQ(room.inferred_share(), 0.0);
}

}  // namespace
}  // namespace choreo::vision
