// SPDX-License-Identifier: Apache-2.0
// MATH.md section 2 on masks small enough to be worked by hand.
#include "body/mask_state.hpp"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "support/drawn_masks.hpp"

namespace choreo::body {
namespace {

using test::mask_of;
using test::random_mask;

MaskState state_of(const std::vector<std::string_view>& rows) { return MaskState(mask_of(rows)); }

TEST(MaskState, TheCenterIsTheCentroidRoundedHalfUp) {
  // c = 7/2, C = floor(7/2 + 1/2) = 4, so sum x - C M = 7 - 8 = -1 and f = -1/2.
  const auto half = state_of({".....", ".....", "...##"});
  EXPECT_EQ(half.area(), 2);
  EXPECT_EQ(half.center(), cv::Point(4, 2));
  EXPECT_EQ(half.remainder_x(), -1);
  EXPECT_EQ(half.centroid(), cv::Point2d(3.5, 2.0));
  // c = 4/3, C = 1, f = 1/3.
  const auto third = state_of({"##.#"});
  EXPECT_EQ(third.center(), cv::Point(1, 0));
  EXPECT_EQ(third.remainder_x(), 1);
  // c = 5/3, C = 2, f = -1/3.
  const auto minus_third = state_of({"#.##"});
  EXPECT_EQ(minus_third.center(), cv::Point(2, 0));
  EXPECT_EQ(minus_third.remainder_x(), -1);
  // The same rounding downwards: rows 0 and 1 have their centre in row 1.
  EXPECT_EQ(state_of({"#", "#"}).center(), cv::Point(0, 1));
}

TEST(MaskState, PixelsLieRelativeToTheCenterAndNothingLiesElsewhere) {
  const auto a = state_of({".....", ".#...", ".##.."});
  // sum x = 4, M = 3: C_x = 1; sum y = 5: C_y = 2.
  EXPECT_EQ(a.center(), cv::Point(1, 2));
  EXPECT_EQ(a.box(), cv::Rect(0, -1, 2, 2));
  EXPECT_TRUE(a.at(0, -1));
  EXPECT_TRUE(a.at(0, 0));
  EXPECT_TRUE(a.at(1, 0));
  EXPECT_FALSE(a.at(1, -1));
  EXPECT_FALSE(a.at(-1, 0));
  EXPECT_FALSE(a.at(2, 0));
  EXPECT_FALSE(a.at(0, 1));
  EXPECT_FALSE(a.at(1000000, -1000000));
}

TEST(MaskState, AnyValueButZeroIsBody) {
  cv::Mat mask = cv::Mat::zeros(2, 2, CV_8UC1);
  mask.at<uchar>(0, 0) = 1;
  mask.at<uchar>(1, 1) = 255;
  EXPECT_EQ(MaskState(mask).area(), 2);
}

TEST(MaskState, NoPixelIsLostAtThePicturesEdgesOrBetweenWords) {
  std::mt19937 random(1);
  for (const auto size : {cv::Size(1, 1), cv::Size(63, 3), cv::Size(64, 3), cv::Size(65, 3), cv::Size(130, 7)}) {
    cv::Mat mask = random_mask(random, size, 0.4);
    for (const auto corner : {cv::Point(0, 0), cv::Point(size.width - 1, 0), cv::Point(0, size.height - 1)}) {
      mask.at<uchar>(corner) = 255;
    }
    const MaskState a(mask);
    ASSERT_EQ(a.area(), cv::countNonZero(mask));
    ASSERT_EQ(a.box(), cv::Rect(-a.center().x, -a.center().y, size.width, size.height));
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        ASSERT_EQ(a.at(x - a.center().x, y - a.center().y), mask.at<uchar>(y, x) != 0) << size << x << "," << y;
      }
    }
    // Bits past the box are 0: the fast kernels count whole words.
    if (const auto used = std::size_t(size.width) % 64; used != 0) {
      for (int y = 0; y < size.height; ++y) EXPECT_EQ(a.row(y - a.center().y)[a.row_words() - 1] >> used, 0U);
    }
  }
}

TEST(MaskState, WhereInThePictureTheBodyStandsDoesNotMatter) {
  std::mt19937 random(2);
  const cv::Mat body = random_mask(random, {17, 9}, 0.5);
  const MaskState other(random_mask(random, {14, 12}, 0.5));
  const MaskState home(body);
  for (const auto place : {cv::Rect(0, 0, 17, 9), cv::Rect(1, 5, 17, 9), cv::Rect(83, 51, 17, 9)}) {
    cv::Mat picture = cv::Mat::zeros(60, 100, CV_8UC1);
    body.copyTo(picture(place));
    const MaskState moved(picture);
    EXPECT_EQ(moved.center() - home.center(), place.tl());
    EXPECT_EQ(moved.remainder_x(), home.remainder_x());
    EXPECT_EQ(similarity(moved, home), 1.0);
    EXPECT_EQ(similarity(moved, other), similarity(home, other));
    EXPECT_EQ(mirror_similarity(moved, other), mirror_similarity(home, other));
    EXPECT_EQ(mirror_similarity(moved, home), mirror_similarity(home, home));
  }
}

TEST(MaskState, TheMirrorsShiftIsTheRoundedSumOfTheRemainders) {
  struct Case {
    std::int64_t ra, ma, rb, mb;
    int sigma;
  };
  for (const auto& c : {
           Case{0, 1, 0, 1, 0},       // 0 + 0
           Case{-1, 2, -1, 2, -1},    // -1/2 - 1/2 + 1/2 = -1/2, floor -1: both of even width
           Case{-1, 2, 0, 5, 0},      // -1/2 + 0 + 1/2 = 0, floor 0: the boundary belongs to 0
           Case{-1, 2, -1, 100, -1},  // a little below it
           Case{-1, 2, 1, 3, 0},      // -1/2 + 1/3 + 1/2 = 1/3
           Case{1, 3, 1, 3, 1},       // 2/3 + 1/2 = 7/6
           Case{1, 3, 1, 6, 1},       // 1/2 + 1/2 = 1: the boundary belongs to 1
           Case{1, 3, 1, 7, 0},       // a little below it
           Case{-1, 3, -1, 3, -1},    // -2/3 + 1/2 = -1/6
           Case{-1, 3, -1, 6, 0},     // -1/2 + 1/2 = 0
       }) {
    EXPECT_EQ(mirror_shift(c.ra, c.ma, c.rb, c.mb), c.sigma) << c.ra << "/" << c.ma << " " << c.rb << "/" << c.mb;
    EXPECT_EQ(mirror_shift(c.rb, c.mb, c.ra, c.ma), c.sigma) << "it is symmetric";
  }
  const std::int64_t large = std::int64_t{1} << 29;
  EXPECT_EQ(mirror_shift(-large / 2, large, -large / 2, large), -1) << "no overflow at areas beyond any picture";
  EXPECT_EQ(mirror_shift(large / 2 - 1, large, large / 2 - 1, large), 1);
}

TEST(MaskState, TwoAndThreePixelsCompareAsWorkedByHand) {
  const auto pair = state_of({"##"});    // u = -1, 0
  const auto three = state_of({"###"});  // u = -1, 0, 1
  EXPECT_DOUBLE_EQ(similarity(pair, three), 2 / std::sqrt(6.0));
  EXPECT_DOUBLE_EQ(mirror_similarity(pair, three), 2 / std::sqrt(6.0));  // sigma 0: u = 0, 1
  // u = (0,-1) (0,0) (1,0), f = 1/3, and its mirror image u = (0,-1) (0,0) (-1,0), f = -1/3.
  const auto l = state_of({"#.", "##"});
  const auto j = state_of({".#", "##"});
  EXPECT_DOUBLE_EQ(similarity(l, j), 2.0 / 3);
  EXPECT_EQ(mirror_similarity(l, j), 1.0);
  // sigma = floor(2/3 + 1/2) = 1: the mirror image at (1,-1) (1,0) (0,0) has two pixels in common.
  EXPECT_DOUBLE_EQ(mirror_similarity(l, l), 2.0 / 3);
  // Nothing in common: two pixels far apart have their centre between them.
  EXPECT_EQ(similarity(state_of({"#...#"}), state_of({"#"})), 0.0);
}

TEST(MaskState, ASymmetricBodyOfEvenWidthIsItsOwnMirrorImageExactly) {
  EXPECT_EQ(mirror_similarity(state_of({"##"}), state_of({"##"})), 1.0);
  const auto even = state_of({"..##..", "######", "..##..", ".#..#.", "#....#"});
  const auto odd = state_of({"..#..", "#####", "..#..", ".#.#."});
  EXPECT_EQ(mirror_similarity(even, even), 1.0);
  EXPECT_EQ(mirror_similarity(odd, odd), 1.0);
  EXPECT_EQ(similarity(mirrored(even), even), 1.0);
  EXPECT_EQ(similarity(mirrored(odd), odd), 1.0);
}

TEST(MaskState, TheMirrorImageIsWhatTheFlippedPictureShows) {
  std::mt19937 random(3);
  for (int k = 0; k < 50; ++k) {
    const cv::Mat mask = random_mask(random, {5 + k, 4}, 0.5);
    cv::Mat flipped;
    cv::flip(mask, flipped, 1);
    const auto mirror = mirrored(MaskState(mask));
    const MaskState seen(flipped);
    EXPECT_EQ(mirror.area(), seen.area());
    EXPECT_EQ(mirror.box(), seen.box());
    EXPECT_EQ(mirror.remainder_x(), seen.remainder_x());
    EXPECT_EQ(similarity(mirror, seen), 1.0);
  }
}

TEST(MaskState, MirroringTwiceGivesTheSameBits) {
  std::mt19937 random(4);
  for (int k = 0; k < 50; ++k) {
    // Every other one is a symmetric mask of even width, whose f is -1/2.
    cv::Mat mask = random_mask(random, {60 + k, 3}, 0.5);
    if (k % 2 == 0) {
      cv::Mat flipped;
      cv::flip(mask, flipped, 1);
      mask |= flipped;
    }
    const MaskState a(mask);
    const auto b = mirrored(mirrored(a));
    EXPECT_EQ(a.center(), b.center());
    EXPECT_EQ(a.remainder_x(), b.remainder_x());
    ASSERT_EQ(a.box(), b.box());
    EXPECT_NEAR(a.centroid().x, b.centroid().x, 1e-12);
    EXPECT_EQ(similarity(a, b), 1.0);
  }
}

TEST(MaskState, MirrorSimilarityIsTheSimilarityOfTheMirrorImageWhereTheRoundingAgrees) {
  std::mt19937 random(5);
  int agreeing = 0;
  int others = 0;
  for (int k = 0; k < 400; ++k) {
    const MaskState a(random_mask(random, {4 + k % 5, 3}, 0.5));
    const MaskState b(random_mask(random, {5 + k % 3, 4}, 0.5));
    // mirrored(a) lies at -u, one further to the left where f_a = -1/2 and its own centre is rounded up.
    const int carry = 2 * a.remainder_x() == -a.area() ? 1 : 0;
    if (mirror_shift(a.remainder_x(), a.area(), b.remainder_x(), b.area()) == -carry) {
      EXPECT_EQ(mirror_similarity(a, b), similarity(mirrored(a), b));
      ++agreeing;
    } else {
      ++others;
    }
  }
  EXPECT_GT(agreeing, 200);
  EXPECT_GT(others, 20) << "the shift must have been exercised";
}

}  // namespace
}  // namespace choreo::body
