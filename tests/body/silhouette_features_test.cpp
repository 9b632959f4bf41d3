// SPDX-License-Identifier: Apache-2.0
#include "body/silhouette_features.hpp"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "support/drawn_masks.hpp"

namespace choreo::body {
namespace {

cv::Mat bar(int x, int width) {
  cv::Mat mask = cv::Mat::zeros(2, 20, CV_8UC1);
  mask(cv::Rect(x, 0, width, 2)) = 255;
  return mask;
}

TEST(Contraction, IsTheBodysShareOfItsBox) {
  EXPECT_EQ(contraction(12, {4, 3}), 1.0);
  EXPECT_EQ(contraction(3, {4, 3}), 0.25);
  EXPECT_EQ(contraction(1, {1, 1}), 1.0);
}

TEST(MotionMeter, ABodyAtRestDoesNotMove) {
  MotionMeter meter(0.2);
  for (int k = 0; k < 20; ++k) EXPECT_EQ(meter.add(bar(3, 4), 8, k / 30.0), 0.0);
}

TEST(MotionMeter, TheFirstPictureHasNoMotionYet) {
  MotionMeter meter(0.2);
  EXPECT_EQ(meter.add(bar(3, 4), 8, 17.0), 0.0);
}

TEST(MotionMeter, CountsWhatWasCoveredAndIsNoMoreOverTheAreaNow) {
  MotionMeter meter(1.0);
  EXPECT_EQ(meter.add(bar(0, 4), 8, 0.0), 0.0);
  EXPECT_EQ(meter.add(bar(1, 4), 8, 0.1), 2.0 / 8);  // One column of two pixels left behind.
  EXPECT_EQ(meter.add(bar(6, 5), 10, 0.2), 1.0);     // Columns 0 to 4 left behind: ten pixels, each counted once.
  EXPECT_EQ(meter.add(bar(0, 20), 40, 0.3), 0.0);    // A growing body leaves nothing behind.
}

TEST(MotionMeter, ForgetsWhatIsOlderThanItsWindow) {
  MotionMeter meter(0.25);
  EXPECT_EQ(meter.add(bar(0, 4), 8, 0.0), 0.0);
  EXPECT_EQ(meter.add(bar(10, 4), 8, 0.25), 1.0) << "exactly the window's length ago still counts";
  EXPECT_EQ(meter.add(bar(10, 4), 8, 0.3125), 0.0) << "the first picture is out of the window";
}

TEST(MotionMeter, TheWindowIsInSecondsWhateverTheFrameRate) {
  // A body that moves 10 columns a second, in a window of half a second, at two frame rates.
  for (const int fps : {10, 20}) {
    MotionMeter meter(0.5);
    double motion = 0;
    for (int k = 0; k <= fps; ++k) motion = meter.add(bar(k * 10 / fps, 5), 10, double(k) / fps);
    EXPECT_EQ(motion, 1.0) << fps;  // Five columns left behind.
  }
}

TEST(MotionMeter, AfterAResetItStartsAnew) {
  MotionMeter meter(1.0);
  EXPECT_EQ(meter.add(bar(0, 4), 8, 0.0), 0.0);
  meter.reset();
  EXPECT_EQ(meter.add(bar(10, 4), 8, 0.1), 0.0);
}

TEST(MotionMeter, LeavesTheMasksAlone) {
  MotionMeter meter(1.0);
  const cv::Mat first = bar(0, 4);
  (void)meter.add(first, 8, 0.0);
  (void)meter.add(bar(2, 4), 8, 0.1);
  (void)meter.add(bar(4, 4), 8, 0.2);
  EXPECT_TRUE(test::same_bytes(first, bar(0, 4)));
}

}  // namespace
}  // namespace choreo::body
