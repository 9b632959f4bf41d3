// SPDX-License-Identifier: Apache-2.0
// What the first Kinect's depth words mean, and where they lie in the colour picture.
#include "devices/media/kinect_depth.hpp"

#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "support/frames.hpp"

namespace choreo::devices {
namespace {

TEST(KinectMillimetres, AreThoseOfTheFormulaByHand) {
  // 800: x = -0.375 * 0.1042 = -0.039075; 10 * (120 x / (7.5 - x) + 120) = 1193.78.
  EXPECT_EQ(kinect_millimetres(800), 1193);
  // 600: x = -50.375 * 0.1042 = -5.249075; 10 * (-629.889 / 12.749075 + 120) = 705.93.
  EXPECT_EQ(kinect_millimetres(600), 705);
  // 1000: x = 49.625 * 0.1042 = 5.170925; 10 * (620.511 / 2.329075 + 120) = 3864.20.
  EXPECT_EQ(kinect_millimetres(1000), 3864);
}

TEST(KinectMillimetres, NothingIsKnownOfTheWordForNothingOrOfMoreThanElevenBits) {
  for (const int word : {2047, 2048, 4095, 32768, 65535}) {
    EXPECT_EQ(kinect_millimetres(static_cast<std::uint16_t>(word)), 0) << word;
  }
}

TEST(KinectMillimetres, GrowWithTheWordWithinTheRangeAndAreNoneOutsideIt) {
  int last = 0;
  int known = 0;
  bool ended = false;
  for (int word = 0; word < 2048; ++word) {
    const int mm = kinect_millimetres(static_cast<std::uint16_t>(word));
    if (mm == 0) {
      ended = known > 0;
      continue;
    }
    EXPECT_FALSE(ended) << "a hole before word " << word;
    EXPECT_GE(mm, last) << word;
    EXPECT_GE(mm, 400);
    EXPECT_LE(mm, 10000);
    last = mm;
    ++known;
  }
  EXPECT_GT(known, 800);
  EXPECT_GT(last, 9700) << "the range is used up to its end";
}

TEST(KinectWord, ComesBackToTheSameDistance) {
  for (int word = 0; word < 2048; ++word) {
    const auto mm = kinect_millimetres(static_cast<std::uint16_t>(word));
    EXPECT_EQ(kinect_millimetres(kinect_word(mm)), mm) << word;
  }
}

TEST(KinectWord, NoOtherWordIsNearer) {
  for (int mm = 400; mm <= 10000; ++mm) {
    const auto word = kinect_word(static_cast<std::uint16_t>(mm));
    const int off = std::abs(kinect_millimetres(word) - mm);
    for (const int other : {word - 1, word + 1}) {
      const int theirs = kinect_millimetres(static_cast<std::uint16_t>(other));
      if (theirs != 0) {
        EXPECT_LE(off, std::abs(theirs - mm)) << mm << " mm";
      }
    }
  }
}

TEST(KinectWord, OfNothingAndOutOfRangeIsTheWordForNothing) {
  for (const int mm : {0, 1, 399, 10001, 65535}) EXPECT_EQ(kinect_word(static_cast<std::uint16_t>(mm)), 2047) << mm;
}

TEST(KinectDepth, WordsHaveTheLowByteFirst) {
  // 0x0320 = 800, 0x07ff = 2047, 0x03e8 = 1000, and one with a bit too many.
  const std::vector<std::uint8_t> words = {0x20, 0x03, 0xff, 0x07, 0xe8, 0x03, 0x20, 0x0b};
  const cv::Mat expected = (cv::Mat_<std::uint16_t>(2, 2) << 1193, 0, 3864, 0);
  EXPECT_TRUE(test::same_pixels(kinect_depth(words, {2, 2}), expected));
}

TEST(KinectDepth, AnotherNumberOfBytesIsRefused) {
  const std::vector<std::uint8_t> words(8);
  for (const cv::Size size : {cv::Size(2, 1), cv::Size(3, 2), cv::Size(0, 0), cv::Size(-2, -2)}) {
    EXPECT_TRUE(test::error_of([&] { (void)kinect_depth(words, size); })) << size;
  }
  EXPECT_TRUE(test::error_of([&] { (void)kinect_depth({}); }));
}

cv::Mat nothing() { return cv::Mat::zeros(kKinectSize, CV_16UC1); }

std::vector<cv::Point> places_of(const cv::Mat& depth) {
  std::vector<cv::Point> places;
  cv::findNonZero(depth, places);
  return places;
}

TEST(KinectRegistered, MovesAPointByTheLensesAndTheParallaxByHand) {
  // (500, 400) at 1 m: (500 - 319.5) * 525 / 580 - 525 * 25 / 1000 + 319.5 = 469.76; (400 - 239.5) * 525 / 580 + 239.5
  // = 384.78.
  cv::Mat depth = nothing();
  depth.at<std::uint16_t>(400, 500) = 1000;
  const auto seen = kinect_registered(depth);
  ASSERT_EQ(places_of(seen), std::vector<cv::Point>{cv::Point(470, 385)});
  EXPECT_EQ(seen.at<std::uint16_t>(385, 470), 1000);
}

TEST(KinectRegistered, TheNearerHidesTheFarther) {
  // A wall at 5 m along line 240, which stays, and one point at 1 m: (300 - 319.5) * 525 / 580 - 13.125 + 319.5 =
  // 288.72.
  for (const auto& [x, place] : {std::pair(300, 289), std::pair(400, 379)}) {
    cv::Mat depth = nothing();
    depth.row(240).setTo(5000);
    depth.at<std::uint16_t>(240, x) = 1000;
    const auto seen = kinect_registered(depth);
    EXPECT_EQ(seen.at<std::uint16_t>(240, place), 1000);
    EXPECT_EQ(cv::countNonZero(seen == 1000), 1);
  }
}

TEST(KinectRegistered, AWallStaysWithoutHolesWhereBothCamerasSeeIt) {
  const auto seen = kinect_registered(cv::Mat(kKinectSize, CV_16UC1, cv::Scalar(2000)));
  // The depth camera sees less of it than the colour camera, by 525 / 580, and 6.6 pixels more to the right.
  const cv::Rect both(25, 24, 575, 432);
  EXPECT_EQ(cv::countNonZero(seen(both)), both.area());
  EXPECT_NEAR(cv::countNonZero(seen), 640 * 480 * 525.0 / 580 * 525.0 / 580, 640 * 480 * 0.01);
  EXPECT_EQ(cv::countNonZero(seen.colRange(620, 640)), 0);
}

TEST(KinectRegistered, NothingAndTooFarStayNothing) {
  EXPECT_EQ(cv::countNonZero(kinect_registered(nothing())), 0);
  EXPECT_EQ(cv::countNonZero(kinect_registered(cv::Mat(kKinectSize, CV_16UC1, cv::Scalar(65535)))), 0);
  // So near that everything leaves to the left.
  EXPECT_EQ(cv::countNonZero(kinect_registered(cv::Mat(kKinectSize, CV_16UC1, cv::Scalar(1)))), 0);
}

TEST(KinectRegistered, AnotherPictureIsRefused) {
  EXPECT_TRUE(test::error_of([] { (void)kinect_registered(cv::Mat()); }));
  EXPECT_TRUE(test::error_of([] { (void)kinect_registered(cv::Mat::zeros(240, 320, CV_16UC1)); }));
  EXPECT_TRUE(test::error_of([] { (void)kinect_registered(cv::Mat::zeros(kKinectSize, CV_32FC1)); }));
}

}  // namespace
}  // namespace choreo::devices
