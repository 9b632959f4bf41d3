// SPDX-License-Identifier: Apache-2.0
// The overlay: type and rings where they are said to be, at any size, and nothing where there is nothing to say.
#include "outputs/signal_overlay.hpp"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace choreo::outputs {
namespace {

cv::Mat grey(int width, int height) { return {height, width, CV_8UC3, cv::Scalar::all(120)}; }

// Pixels of a part of the picture that the overlay changed.
int changed(const cv::Mat& before, const cv::Mat& after, cv::Rect where) {
  cv::Mat difference;
  cv::absdiff(before(where), after(where), difference);
  return cv::countNonZero(difference.reshape(1));
}

TEST(RingOf, IsTheEllipseThatHasTheMomentsOfTheRegion) {
  // An upright bar of 2 x 12, as a full ellipse with half axes 1 and 6 would have them: a quarter of the squares.
  const auto upright = ring_of({5, 7}, 0.25, 0, 9);
  EXPECT_NEAR(upright.half.width, 6, 1e-12);
  EXPECT_NEAR(upright.half.height, 1, 1e-12);
  EXPECT_NEAR(std::abs(upright.angle_deg), 90, 1e-12);
  // Longest from the upper left to the lower right: y points down.
  const auto falling = ring_of({0, 0}, 5, 4, 5);
  EXPECT_NEAR(falling.angle_deg, 45, 1e-12);
  EXPECT_NEAR(falling.half.width, 6, 1e-12);
  EXPECT_NEAR(falling.half.height, 2, 1e-12);
}

TEST(SignalOverlay, WithNothingToSayThePictureStaysAsItIs) {
  const auto picture = grey(160, 120);
  EXPECT_EQ(changed(picture, drawn_over(picture, {}), {0, 0, 160, 120}), 0);
}

TEST(SignalOverlay, TheLetterStandsLargeInTheLowerLeftAndTheUpperHalfIsFree) {
  const auto picture = grey(640, 480);
  const auto shown = drawn_over(picture, {.letter = "R", .beside = "0.97, then D", .text = "HELLO WOR"});
  EXPECT_GT(changed(picture, shown, {0, 240, 320, 240}), 10'000);
  EXPECT_EQ(changed(picture, shown, {0, 0, 640, 240}), 0);
  EXPECT_EQ(changed(picture, grey(640, 480), {0, 0, 640, 480}), 0) << "the picture given is not drawn on";
}

TEST(SignalOverlay, ALongWordOrTextKeepsInsideThePicture) {
  const auto picture = grey(320, 240);
  const auto shown = drawn_over(picture, {.letter = "NUMERALS", .text = std::string(400, 'W') + "END"});
  EXPECT_EQ(shown.size(), picture.size());
  EXPECT_EQ(changed(picture, shown, {120, 0, 200, 200}), 0) << "where the body is";
}

TEST(SignalOverlay, RingsAreDrawnWhereFaceAndArmsAre) {
  const auto picture = grey(320, 240);
  const auto shown = drawn_over(picture, {.faces = {{{160, 60}, {20, 25}}}, .arms = {{{240, 100}, {40, 8}, 30}}});
  EXPECT_GT(changed(picture, shown, {135, 30, 50, 60}), 100);
  EXPECT_EQ(changed(picture, shown, {150, 50, 20, 20}), 0) << "a ring has no filling";
  EXPECT_GT(changed(picture, shown, {200, 70, 80, 60}), 100);
}

TEST(SignalOverlay, AnySizeOfPictureAndAnyBytesOfTextAreDrawn) {
  for (const auto size : {cv::Size(1, 1), cv::Size(17, 400), cv::Size(1920, 16)}) {
    const auto shown =
        drawn_over(grey(size.width, size.height), {.letter = "\xff\n", .beside = "\xc3", .text = "\xe2\x82 \x01"});
    EXPECT_EQ(shown.size(), size);
  }
}

}  // namespace
}  // namespace choreo::outputs
