// SPDX-License-Identifier: Apache-2.0
// Grey is told from colour, noise and codecs notwithstanding.
#include "vision/colourless.hpp"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace choreo::vision {
namespace {

TEST(Colourless, APictureOfGreysIsItHoweverBright) {
  cv::Mat ramp(64, 256, CV_8UC3);
  for (int x = 0; x < ramp.cols; ++x) ramp.col(x).setTo(cv::Scalar::all(x));
  EXPECT_TRUE(colourless(ramp));
}

TEST(Colourless, WhatACodecMakesOfGreyIsStillGrey) {
  // Channels up to 8 apart.
  EXPECT_TRUE(colourless(cv::Mat(48, 64, CV_8UC3, cv::Scalar(120, 124, 128))));
  EXPECT_FALSE(colourless(cv::Mat(48, 64, CV_8UC3, cv::Scalar(120, 124, 129))));
}

TEST(Colourless, OnePixelInAThousandOfColourIsColour) {
  cv::Mat picture(40, 50, CV_8UC3, cv::Scalar::all(90));
  picture.at<cv::Vec3b>(0, 0) = {60, 90, 160};
  EXPECT_TRUE(colourless(picture)) << "1 of 2000";
  picture.at<cv::Vec3b>(39, 49) = {60, 90, 160};
  EXPECT_FALSE(colourless(picture)) << "2 of 2000";
}

TEST(Colourless, AnEmptyPictureHasNoColour) { EXPECT_TRUE(colourless({})); }

}  // namespace
}  // namespace choreo::vision
