// SPDX-License-Identifier: Apache-2.0
// The working resolution: its size for every picture, and what a smaller picture shows.
#include "pipeline/working_size.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace choreo::pipeline
