// SPDX-License-Identifier: Apache-2.0
// The triangle that scrolls: each pair in its pixel, once, and what is old leaves on the left.
#include "similarity/scrolling_triangle.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "support/states.hpp"

namespace choreo::similarity {
namespace {

using test::kNaN;

const cv::Vec3b kGap(90, 60, 60);
const cv::Vec3b kBlank(20, 20, 20);
const cv::Vec3b kRed(0, 0, 255);
const cv::Vec3b kCyan(255, 255, 0);
const cv::Vec3b kBlack(0, 0, 0);

// Frames of a source: Z and Z* of frames i and j by a rule.
template <typename Rule>
void run(ScrollingTriangle& triangle, int frames, double step_s, Rule rule, int history = 1 << 20, int from = 0) {
  for (int i = from; i < from + frames; ++i) {
    std::vector<float> z;
    std::vector<float> zstar;
    for (int j = std::max(0, i - history + 1); j <= i; ++j) {
      const auto [a, b] = rule(i, j);
      z.push_back(a);
      zstar.push_back(b);
    }
    triangle.add_row(i * step_s, z, zstar);
  }
}

// The pixel of a mean time before the newest column's end and a lag.
cv::Vec3b pixel(const cv::Mat& picture, int columns_before_now, int lag_row) {
  return picture.at<cv::Vec3b>(picture.rows - 1 - lag_row, picture.cols - 1 - columns_before_now);
}

TEST(ScrollingTriangle, BeforeTheFirstRowNothingIsThere) {
  const auto picture = ScrollingTriangle(10, 40, kGap, kBlank).picture();
  EXPECT_EQ(picture.size(), cv::Size(40, 20));
  EXPECT_EQ(picture.type(), CV_8UC3);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 40; ++x) EXPECT_EQ(picture.at<cv::Vec3b>(y, x), kBlank);
  }
}

// Z = 1 and Z* = 0 on the identity axis, nothing alike elsewhere.
std::pair<float, float> only_itself(int i, int j) { return i == j ? std::pair(1.0F, 0.0F) : std::pair(0.0F, 0.0F); }

TEST(ScrollingTriangle, TheIdentityAxisIsTheBase) {
  for (const double step : {0.25, 0.5, 1.0}) {  // A pixel is 0.25 s: a frame has one, two or four of them.
    ScrollingTriangle triangle(10, 40, kGap, kBlank);
    run(triangle, int(20 / step), step, only_itself);
    const auto picture = triangle.picture();
    for (int x = 4; x < 36; ++x) {
      // A pixel is 0.5 s high, and a square on its tip in the matrix: it has a part of the neighbouring pairs as well.
      EXPECT_GE(pixel(picture, x, 0)[2], 127) << step << " s, " << x << " before now";
      EXPECT_EQ(pixel(picture, x, 0)[0], 0);
    }
    for (int x = 8; x < 30; ++x) EXPECT_EQ(pixel(picture, x, int(2 * step / 0.5) + 1), kBlack) << step;
  }
}

TEST(ScrollingTriangle, ARepetitionIsALineAtItsLag) {
  // The state comes back after 2 s, mirrored after 3 s; a pixel is 0.1 s wide and 0.2 s high, a frame 0.1 s.
  ScrollingTriangle triangle(12, 120, kGap, kBlank);
  run(triangle, 300, 0.1, [](int i, int j) { return std::pair(i - j == 20 ? 1.0F : 0.0F, i - j == 30 ? 1.0F : 0.0F); });
  const auto picture = triangle.picture();
  // Pixel row r is for lags from 0.2 r to 0.2 (r + 1).
  for (int x = 24; x < 80; ++x) {
    int red = 0;
    int cyan = 0;
    for (int r = 0; r < std::min(30, x - 2); ++r) {
      const auto p = pixel(picture, x, r);
      if (p[2] > 0) {
        EXPECT_TRUE(r == 9 || r == 10) << r;
        red += p[2];
      }
      if (p[0] > 0) {
        EXPECT_TRUE(r == 14 || r == 15) << r;
        cyan += p[0];
      }
    }
    EXPECT_GE(red, 60) << x;
    EXPECT_GE(cyan, 60) << x;
  }
}

TEST(ScrollingTriangle, ManyFramesAPixelBecomeTheirMean) {
  // 20 frames a pixel: every second pair is alike.
  ScrollingTriangle triangle(40, 40, kGap, kBlank);
  run(triangle, 800, 0.05, [](int i, int j) { return std::pair((i + j) % 2 == 0 ? 1.0F : 0.0F, 0.25F); });
  const auto picture = triangle.picture();
  for (int x = 10; x < 30; ++x) {
    for (int r = 0; r < 4; ++r) {
      const auto p = pixel(picture, x, r);
      EXPECT_NEAR(p[2], 127.5, 4) << x << " " << r;
      EXPECT_NEAR(p[0], 0.25 * 255, 1);
    }
  }
}

TEST(ScrollingTriangle, NoPixelOfTheTriangleIsLeftOutWhateverTheFrameRate) {
  for (const double step : {0.011, 0.04, 0.049, 0.051, 0.1, 0.13, 0.7}) {  // A pixel is 0.1 s.
    ScrollingTriangle triangle(8, 80, kGap, kBlank);
    run(triangle, int(20 / step), step, [](int, int) { return std::pair(1.0F, 1.0F); });
    const auto picture = triangle.picture();
    const int margin = 3 + int(step / 0.1);
    for (int r = 0; r < 40; ++r) {
      for (int x = r + margin; x < 80 - r - margin; ++x) {
        ASSERT_EQ(pixel(picture, x, r), cv::Vec3b(255, 255, 255)) << step << " s: " << x << ", " << r;
      }
    }
  }
}

TEST(ScrollingTriangle, UnevenTimesLeaveNoHolesEither) {
  ScrollingTriangle triangle(8, 80, kGap, kBlank);
  double time = 0;
  std::vector<float> ones;
  for (int i = 0; i < 400; ++i) {
    ones.push_back(1.0F);
    triangle.add_row(time, ones, ones);
    time += i % 7 == 0 ? 0.4 : (i % 3 == 0 ? 0.02 : 0.06);
  }
  const auto picture = triangle.picture();
  for (int r = 0; r < 38; ++r) {
    for (int x = r + 8; x < 72 - r; ++x) ASSERT_EQ(pixel(picture, x, r), cv::Vec3b(255, 255, 255)) << x << ", " << r;
  }
}

TEST(ScrollingTriangle, WithoutABodyThereIsAGap) {
  ScrollingTriangle triangle(10, 40, kGap, kBlank);
  run(triangle, 80, 0.25, [](int i, int j) {
    const bool gone = i / 4 == 15 || j / 4 == 15;  // From 15 s to 16 s of 20 s.
    return gone ? std::pair(kNaN, kNaN) : std::pair(1.0F, 0.0F);
  });
  const auto picture = triangle.picture();
  EXPECT_EQ(pixel(picture, 17, 0), kGap);
  EXPECT_EQ(pixel(picture, 18, 0), kGap);
  EXPECT_EQ(pixel(picture, 10, 0), kRed);
  EXPECT_EQ(pixel(picture, 25, 0), kRed);
}

TEST(ScrollingTriangle, AHistoryShorterThanThePictureLeavesTheRestBlank) {
  ScrollingTriangle triangle(10, 40, kGap, kBlank);
  run(
      triangle, 80, 0.25, [](int, int) { return std::pair(1.0F, 0.0F); }, 8);
  const auto picture = triangle.picture();
  EXPECT_EQ(pixel(picture, 20, 0), kRed);
  EXPECT_EQ(pixel(picture, 20, 2), kRed) << "a lag of 1 s";
  EXPECT_EQ(pixel(picture, 20, 8), kBlank) << "a lag of 4 s, and the history is 2 s long";
}

TEST(ScrollingTriangle, APauseLongerThanThePictureClearsIt) {
  ScrollingTriangle triangle(10, 40, kGap, kBlank);
  run(triangle, 40, 0.25, only_itself);
  const std::vector<float> row(41, 0.0F);
  triangle.add_row(1000.0, row, row);
  const auto picture = triangle.picture();
  // The newest frame is taken to have been on for a second: four columns.
  for (int x = 7; x < 40; ++x) EXPECT_EQ(pixel(picture, x, 0), kBlank) << x;
  EXPECT_EQ(pixel(picture, 2, 0), kBlack);
}

TEST(ScrollingTriangle, ScrollingMovesThePictureAndChangesNoPixelOfIt) {
  ScrollingTriangle triangle(10, 40, kGap, kBlank);
  const auto rule = [](int i, int j) {
    return std::pair(float((i * 7 + j * 3) % 11) / 10.0F, float((i + j) % 5) / 4.0F);
  };
  run(triangle, 60, 0.25, rule);
  const auto before = triangle.picture();
  EXPECT_NE(pixel(before, 12, 3), pixel(before, 13, 3)) << "one colour looks the same wherever it is moved to";
  run(triangle, 4, 0.25, rule, 1 << 20, 60);
  const auto after = triangle.picture();
  for (int r = 0; r < 18; ++r) {
    for (int x = r + 2; x < 34 - r; ++x) {
      EXPECT_EQ(pixel(after, x + 4, r), pixel(before, x, r)) << x << ", " << r;
    }
  }
}

}  // namespace
}  // namespace choreo::similarity
