// SPDX-License-Identifier: Apache-2.0
// The working resolution: its size for every picture, and what a smaller picture shows.
#include "pipeline/working_size.hpp"

#include <utility>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "support/frames.hpp"

namespace choreo::pipeline {
namespace {

TEST(WorkingSize, KeepsTheShapeAndTheRowsAskedFor) {
  EXPECT_EQ(working_size({1920, 1080}, 480), cv::Size(853, 480)) << "853.33 to the nearest";
  EXPECT_EQ(working_size({1080, 1920}, 480), cv::Size(270, 480));
  EXPECT_EQ(working_size({640, 480}, 120), cv::Size(160, 120));
  EXPECT_EQ(working_size({7680, 4320}, 480), cv::Size(853, 480));
}

TEST(WorkingSize, NeverEnlarges) {
  EXPECT_EQ(working_size({320, 240}, 480), cv::Size(320, 240));
  EXPECT_EQ(working_size({640, 480}, 480), cv::Size(640, 480));
  EXPECT_EQ(working_size({1, 1}, 480), cv::Size(1, 1));
}

TEST(WorkingSize, ZeroRowsMeanNoLimit) { EXPECT_EQ(working_size({4000, 3000}, 0), cv::Size(4000, 3000)); }

TEST(WorkingSize, IsNeverNarrowerThanOnePixel) {
  EXPECT_EQ(working_size({1, 4000}, 10), cv::Size(1, 10));
  EXPECT_EQ(working_size({3, 4000}, 1), cv::Size(1, 1));
}

TEST(AtWorkingSize, EachPixelIsTheMeanOfWhatItCovers) {
  cv::Mat picture(2, 4, CV_8UC3, cv::Scalar::all(0));
  picture.at<cv::Vec3b>(0, 0) = {40, 80, 120};  // One of the four pixels under the left one.
  picture(cv::Rect(2, 0, 2, 2)).setTo(cv::Scalar(9, 8, 7));
  const auto small = at_working_size(picture, {2, 1});
  EXPECT_EQ(small.size(), cv::Size(2, 1));
  EXPECT_EQ(small.at<cv::Vec3b>(0, 0), cv::Vec3b(10, 20, 30));
  EXPECT_EQ(small.at<cv::Vec3b>(0, 1), cv::Vec3b(9, 8, 7));
}

TEST(AtWorkingSize, ManyCoresGiveTheBitsOfOne) {
  // 480 rows of 1080 are 9/4 to one, of 1944 81/20, which no number of bits holds; 1001 and 480 have nothing in common.
  for (const auto& [from, rows] : {std::pair{cv::Size(1920, 1080), 480},
                                   {{1920, 1080}, 120},
                                   {{1280, 720}, 480},
                                   {{640, 480}, 120},
                                   {{2592, 1944}, 480},
                                   {{1333, 1001}, 480},
                                   {{1, 4000}, 10}}) {
    const auto picture = test::noise(from, CV_8UC3, 3);
    const auto size = working_size(from, rows);
    cv::Mat at_once;
    cv::resize(picture, at_once, size, 0, 0, cv::INTER_AREA);
    EXPECT_TRUE(test::same_pixels(at_working_size(picture, size), at_once)) << from << " to " << rows << " rows";
  }
}

TEST(AtWorkingSize, APictureOfThatSizeIsNotCopied) {
  const auto picture = test::noise({5, 4}, CV_8UC3, 1);
  EXPECT_EQ(at_working_size(picture, {5, 4}).data, picture.data);
}

TEST(AtWorkingSize, ThePictureItselfIsLeftAsItWas) {
  const auto picture = test::noise({8, 6}, CV_8UC3, 2);
  const auto before = picture.clone();
  const auto small = at_working_size(picture, {4, 3});
  EXPECT_NE(small.data, picture.data);
  EXPECT_TRUE(test::same_pixels(picture, before));
}

TEST(DepthAtWorkingSize, IsTheMiddleOneOfTheValidReadingsAndNeverAMean) {
  const cv::Mat1w depth = (cv::Mat1w(2, 6) << 1000, 1000, 2000, 0, 0, 0,  //
                           1000, 3000, 3000, 0, 0, 900);
  const cv::Mat1w small = depth_at_working_size(depth, {3, 1});
  EXPECT_EQ(small(0, 0), 1000);
  EXPECT_EQ(small(0, 1), 2000) << "the nearer of two, which are half of what is covered";
  EXPECT_EQ(small(0, 2), 0) << "one of four is no evidence";
}

TEST(DepthAtWorkingSize, NothingChangesAtItsOwnSizeAndNothingComesOfNothing) {
  const auto depth = test::noise({7, 5}, CV_16UC1, 3);
  EXPECT_EQ(depth_at_working_size(depth, {7, 5}).data, depth.data);
  EXPECT_TRUE(depth_at_working_size(cv::Mat(), {7, 5}).empty());
}

TEST(DepthAtWorkingSize, EveryPixelIsAReadingOfThePlaceItCoversAtAnyRatio) {
  const auto depth = test::noise({33, 21}, CV_16UC1, 3) + 1;
  const cv::Mat all = depth;
  for (const cv::Size size : {cv::Size(32, 20), cv::Size(10, 7), cv::Size(1, 1), cv::Size(50, 40)}) {
    const auto out = depth_at_working_size(all, size);
    ASSERT_EQ(out.size(), size);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const cv::Rect place(cv::Point(x * 33 / size.width, y * 21 / size.height),
                             cv::Point((x + 1) * 33 / size.width + 1, (y + 1) * 21 / size.height + 1));
        const cv::Mat part = all(place & cv::Rect(0, 0, 33, 21));
        EXPECT_GT(cv::countNonZero(part == double(out.at<std::uint16_t>(y, x))), 0) << x << "," << y;
      }
    }
  }
}

}  // namespace
}  // namespace choreo::pipeline
