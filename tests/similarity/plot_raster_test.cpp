// SPDX-License-Identifier: Apache-2.0
#include "similarity/plot_raster.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "core/error.hpp"
#include "support/states.hpp"

namespace choreo::similarity {
namespace {

using test::kNaN;

struct Symmetric {
  std::size_t n;
  std::vector<float> values;
  explicit Symmetric(std::size_t size) : n(size), values(size * size) {}
  void set(std::size_t a, std::size_t b, float v) { values[a * n + b] = values[b * n + a] = v; }
  [[nodiscard]] float at(std::size_t a, std::size_t b) const { return values[a * n + b]; }
  [[nodiscard]] MatrixView<const float> view() const { return {values.data(), n, n}; }
  void gap(std::size_t a) {
    for (std::size_t b = 0; b < n; ++b) set(a, b, kNaN);
  }
};

/// Frames seen for 1, 2 and 2 seconds.
const std::vector<double> kThreeTimes = {0.0, 1.0, 3.0};

Symmetric three() {
  Symmetric m(3);
  for (std::size_t i = 0; i < 3; ++i) m.set(i, i, 1.0F);
  m.set(0, 1, 0.5F);
  m.set(0, 2, 0.25F);
  m.set(1, 2, 0.75F);
  return m;
}

std::vector<double> even_times(std::size_t n, double step = 1.0) {
  std::vector<double> t(n);
  for (std::size_t i = 0; i < n; ++i) t[i] = step * static_cast<double>(i);
  return t;
}

PlotRaster square(const Symmetric& z, std::span<const double> times, std::size_t width) {
  return reduce(PlotForm::kSquare, z.view(), {}, times, width);
}

TEST(FrameEdges, TheLastFrameIsAsLongAsItsPredecessor) {
  EXPECT_EQ(frame_edges(kThreeTimes), (std::vector<double>{0.0, 1.0, 3.0, 5.0}));
  EXPECT_EQ(frame_edges(std::vector{7.0}), (std::vector<double>{7.0, 7.04}));
}

TEST(FrameEdges, TimesThatDoNotGrowAreRefused) {
  for (const auto& bad : {std::vector<double>{}, {0.0, 0.0}, {1.0, 0.5}, {0.0, std::nan("")}, {0.0, INFINITY}}) {
    EXPECT_THROW((void)frame_edges(bad), Error);
  }
}

TEST(PlotRaster, APixelIsTheMeanOverItsAreaInTrueTime) {
  const auto one = square(three(), kThreeTimes, 1);
  // (1*1 + 2*2 + 2*2 + 2 (1*2*0.5 + 1*2*0.25 + 2*2*0.75)) / 25
  ASSERT_EQ(one.z.size(), 1u);
  EXPECT_FLOAT_EQ(one.z[0], 0.72F);
  EXPECT_EQ(one.begin_s, 0.0);
  EXPECT_EQ(one.end_s, 5.0);
  // Pixels of 2.5 s: 1 s of frame 0 and 1.5 s of frame 1; 0.5 s of frame 1 and 2 s of frame 2.
  const auto two = square(three(), kThreeTimes, 2);
  EXPECT_FLOAT_EQ(two.z[0], 4.75F / 6.25F);
  EXPECT_FLOAT_EQ(two.z[1], 3.75F / 6.25F);
  EXPECT_FLOAT_EQ(two.z[2], 3.75F / 6.25F);
  EXPECT_FLOAT_EQ(two.z[3], 5.75F / 6.25F);
}

TEST(PlotRaster, AShortRecordingIsEnlargedToCrispCells) {
  const auto m = three();
  const auto raster = square(m, kThreeTimes, 10);
  const std::size_t frame_of[] = {0, 0, 1, 1, 1, 1, 2, 2, 2, 2};
  for (std::size_t r = 0; r < 10; ++r) {
    for (std::size_t c = 0; c < 10; ++c)
      EXPECT_EQ(raster.z[r * 10 + c], m.at(frame_of[r], frame_of[c])) << r << " " << c;
  }
}

TEST(PlotRaster, FramesWithoutABodyAreLeftOutOfTheMean) {
  auto m = three();
  m.gap(1);
  const auto two = square(m, kThreeTimes, 2);
  EXPECT_FLOAT_EQ(two.z[0], 1.0F);
  EXPECT_FLOAT_EQ(two.z[1], 0.25F);
  EXPECT_FLOAT_EQ(two.z[3], 1.0F);
  EXPECT_FALSE(has_gaps(two, PlotChannels::kZ));
}

TEST(PlotRaster, APixelWithoutAnyBodyIsAGapAndNotZero) {
  auto m = three();
  m.set(0, 2, 0.0F);
  m.gap(1);
  const auto raster = square(m, kThreeTimes, 5);
  EXPECT_TRUE(std::isnan(raster.z[1]));
  EXPECT_TRUE(std::isnan(raster.z[2 * 5 + 4]));
  EXPECT_EQ(raster.z[3], 0.0F);
  EXPECT_TRUE(has_gaps(raster, PlotChannels::kZ));
  const cv::Vec3b tone(1, 2, 3);
  const auto picture = paint(raster, PlotChannels::kZ, {}, tone);
  EXPECT_EQ(picture.at<cv::Vec3b>(0, 1), tone);
  EXPECT_EQ(picture.at<cv::Vec3b>(0, 3), cv::Vec3b(0, 0, 0));
}

/// Uneven times and some gaps; every pixel against the definition, summed up the slow way.
TEST(PlotRaster, EveryPixelOfAnUnevenRecordingIsTheMeanByDefinition) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (const std::size_t n : {1u, 2u, 5u, 17u, 64u}) {
    Symmetric m(n);
    std::vector<double> times(n, 10.0);
    for (std::size_t i = 0; i < n; ++i) {
      if (i > 0) times[i] = times[i - 1] + 0.01 + uniform(random);
      for (std::size_t j = 0; j <= i; ++j) m.set(i, j, static_cast<float>(uniform(random)));
    }
    for (std::size_t i = 3; i < n; i += 7) m.gap(i);
    const auto edges = frame_edges(times);
    for (const std::size_t width : {1u, 4u, 13u, 40u}) {
      const auto raster = square(m, times, width);
      const double pixel = (edges.back() - edges.front()) / static_cast<double>(width);
      const auto overlap = [&](std::size_t frame, std::size_t p) {
        const double begin = edges.front() + pixel * static_cast<double>(p);
        return std::max(0.0, std::min(edges[frame + 1], begin + pixel) - std::max(edges[frame], begin)) / pixel;
      };
      for (std::size_t r = 0; r < width; ++r) {
        for (std::size_t c = 0; c < width; ++c) {
          double sum = 0.0, weight = 0.0;
          for (std::size_t i = 0; i < n; ++i) {
            for (std::size_t j = 0; j < n; ++j) {
              if (std::isnan(m.at(i, j))) continue;
              sum += overlap(i, r) * overlap(j, c) * static_cast<double>(m.at(i, j));
              weight += overlap(i, r) * overlap(j, c);
            }
          }
          const float value = raster.z[r * width + c];
          if (weight > 1e-7) {
            EXPECT_NEAR(value, sum / weight, 1e-5) << n << " " << width << " " << r << " " << c;
          } else if (weight == 0.0) {
            EXPECT_TRUE(std::isnan(value)) << n << " " << width << " " << r << " " << c;
          }
          EXPECT_EQ(std::isnan(value), std::isnan(raster.z[c * width + r]));
          if (!std::isnan(value)) {
            EXPECT_EQ(value, raster.z[c * width + r]);
          }
        }
      }
    }
  }
}

TEST(PlotRaster, ReducingALongRecordingIsReducingItsBlockMeans) {
  constexpr std::size_t kBlock = 40, kBlocks = 30, kFrames = kBlock * kBlocks;
  Symmetric fine(kFrames), coarse(kBlocks);
  std::vector<double> sums(kBlocks * kBlocks);
  for (std::size_t i = 0; i < kFrames; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      const auto v = static_cast<float>(0.5 + 0.5 * std::cos(0.013 * static_cast<double>(i * j % 1000)));
      fine.set(i, j, v);
      sums[i / kBlock * kBlocks + j / kBlock] += static_cast<double>(v);
      if (i != j) sums[j / kBlock * kBlocks + i / kBlock] += static_cast<double>(v);
    }
  }
  for (std::size_t a = 0; a < kBlocks; ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      coarse.set(a, b, static_cast<float>(sums[a * kBlocks + b] / (kBlock * kBlock)));
    }
  }
  const auto from_fine = square(fine, even_times(kFrames, 0.025), kBlocks);
  const auto from_coarse = square(coarse, even_times(kBlocks), kBlocks);
  for (std::size_t k = 0; k < from_fine.z.size(); ++k) EXPECT_NEAR(from_fine.z[k], from_coarse.z[k], 1e-6);
}

TEST(PlotTriangle, APairIsDrawnAtItsMiddleTimeAndItsLag) {
  // Four frames of a second, 8 pixels: half a second across, a second upwards. The pair (3, 0) is a square on its tip
  // around 2 s and a lag of 3 s, a pixel in each direction: half of the pixels under it, all that is inside above it.
  Symmetric m(4);
  m.set(3, 0, 1.0F);
  const auto raster = reduce(PlotForm::kTriangle, m.view(), {}, even_times(4), 8);
  ASSERT_EQ(raster.width, 8u);
  ASSERT_EQ(raster.height, 4u);
  const float n = kNaN;
  const std::vector<float> expected = {n, n, n, 1,    1,    n, n, n,  //
                                       n, n, 0, 0.5F, 0.5F, 0, n, n,  //
                                       n, 0, 0, 0,    0,    0, 0, n,  //
                                       0, 0, 0, 0,    0,    0, 0, 0};
  for (std::size_t k = 0; k < expected.size(); ++k) {
    EXPECT_EQ(std::isnan(raster.z[k]), std::isnan(expected[k])) << k;
    EXPECT_EQ(raster.inside(k / 8, k % 8), !std::isnan(expected[k])) << k;
    if (!std::isnan(expected[k])) {
      EXPECT_FLOAT_EQ(raster.z[k], expected[k]) << k;
    }
  }
}

TEST(PlotTriangle, TheIdentityAxisIsTheBase) {
  Symmetric m(4);
  for (std::size_t i = 0; i < 4; ++i) m.set(i, i, 1.0F);
  const auto raster = reduce(PlotForm::kTriangle, m.view(), {}, even_times(4), 8);
  // A frame with itself is half a square on its tip, two pixels wide and one high: it fills half of each,
  // and all that is inside of the outermost ones.
  for (std::size_t col = 0; col < 8; ++col) {
    EXPECT_FLOAT_EQ(raster.z[3 * 8 + col], col == 0 || col == 7 ? 1.0F : 0.5F);
    if (raster.inside(2, col)) {
      EXPECT_EQ(raster.z[2 * 8 + col], 0.0F);
    }
  }
}

TEST(PlotTriangle, WhatDependsOnTheLagAloneIsARowAndOnTheMiddleTimeAloneAColumn) {
  constexpr std::size_t kFrames = 48, kWidth = 24;
  Symmetric lag(kFrames), middle(kFrames);
  for (std::size_t a = 0; a < kFrames; ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      lag.set(a, b, static_cast<float>(a - b) / kFrames);
      middle.set(a, b, static_cast<float>(a + b + 1) / (2 * kFrames));
    }
  }
  const auto times = even_times(kFrames);
  const auto by_lag = reduce(PlotForm::kTriangle, lag.view(), middle.view(), times, kWidth);
  for (std::size_t row = 0; row < by_lag.height; ++row) {
    for (std::size_t col = 0; col < kWidth; ++col) {
      const std::size_t height = by_lag.height - 1 - row;
      // Pixels that are cut by a side have their mean elsewhere; on the base the lag's kink at 0 adds a little.
      if (col <= height || col + height + 1 >= kWidth) continue;
      const double y = (static_cast<double>(height) + 0.5) / static_cast<double>(by_lag.height);
      const double x = (static_cast<double>(col) + 0.5) / kWidth;
      EXPECT_NEAR(by_lag.z[row * kWidth + col], y, height == 0 ? 0.005 : 1e-6);
      EXPECT_NEAR(by_lag.zstar[row * kWidth + col], x, 1e-6);
    }
  }
}

TEST(PlotTriangle, AGapIsABandFromTheBaseUpwardsInBothDirections) {
  Symmetric m(8);
  m.gap(2);
  const auto raster = reduce(PlotForm::kTriangle, m.view(), {}, even_times(8), 32);
  const auto missing = [&](double middle, double lag) {
    const auto row = raster.height - 1 - static_cast<std::size_t>(lag / 8.0 * 16.0);
    return std::isnan(raster.z[row * 32 + static_cast<std::size_t>(middle / 8.0 * 32.0)]);
  };
  EXPECT_TRUE(missing(2.5, 0.2));
  EXPECT_TRUE(missing((2.5 + 5.5) / 2, 3.0));
  EXPECT_TRUE(missing((2.5 + 0.5) / 2, 2.0));
  EXPECT_FALSE(missing(4.5, 0.2));
  EXPECT_FALSE(missing(2.5, 2.4));
}

TEST(RasterReducer, RowsUpToTheDiagonalAreEnough) {
  const auto m = three();
  RasterReducer reducer(PlotForm::kSquare, kThreeTimes, 7);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto known = m.view().row(i).first(i + 1);
    reducer.add_row(i, known, known);
  }
  const auto raster = reducer.finish();
  EXPECT_EQ(raster.z, square(m, kThreeTimes, 7).z);
  EXPECT_EQ(raster.z, raster.zstar);
}

TEST(RasterReducer, WhatWasNotAddedIsAGap) {
  const auto m = three();
  RasterReducer reducer(PlotForm::kSquare, kThreeTimes, 4);  // Frame 1 ends within the third pixel.
  reducer.add_row(0, m.view().row(0), {});
  reducer.add_row(1, m.view().row(1), {});
  const auto raster = reducer.finish();
  EXPECT_TRUE(raster.zstar.empty());
  EXPECT_EQ(raster.z[2 * 4 + 2], 1.0F);
  EXPECT_TRUE(std::isnan(raster.z[3 * 4 + 3]));
  EXPECT_TRUE(std::isnan(raster.z[3]));
}

TEST(PlotRaster, AMatrixOfAnotherSizeIsRefused) {
  const auto m = three();
  EXPECT_THROW((void)square(m, even_times(4), 4), Error);
}

TEST(PlotColours, RedIsZAndCyanIsZstar) {
  PlotRaster raster{.width = 5, .height = 1, .z = {1, 1, 0, 0, kNaN}, .zstar = {1, 0, 1, 0, 0.5F}};
  const cv::Vec3b gap(9, 8, 7);
  const auto both = paint(raster, PlotChannels::kBoth, {}, gap);
  EXPECT_EQ(both.at<cv::Vec3b>(0), cv::Vec3b(255, 255, 255));
  EXPECT_EQ(both.at<cv::Vec3b>(1), cv::Vec3b(0, 0, 255));
  EXPECT_EQ(both.at<cv::Vec3b>(2), cv::Vec3b(255, 255, 0));
  EXPECT_EQ(both.at<cv::Vec3b>(3), cv::Vec3b(0, 0, 0));
  EXPECT_EQ(both.at<cv::Vec3b>(4), gap);
  EXPECT_EQ(paint(raster, PlotChannels::kZ, {}, gap).at<cv::Vec3b>(1), cv::Vec3b(255, 255, 255));
  EXPECT_EQ(paint(raster, PlotChannels::kZstar, {}, gap).at<cv::Vec3b>(1), cv::Vec3b(0, 0, 0));
  EXPECT_EQ(paint(raster, PlotChannels::kZstar, {}, gap).at<cv::Vec3b>(4), cv::Vec3b(128, 128, 128));
}

TEST(PlotColours, TheRangeIsStretchedAndClamped) {
  EXPECT_EQ(brightness(0.5F, {}), 128);
  EXPECT_EQ(brightness(0.4F, {0.4, 1.0}), 0);
  EXPECT_EQ(brightness(0.75F, {0.5, 1.0}), 128);
  EXPECT_EQ(brightness(0.1F, {0.4, 1.0}), 0);
  EXPECT_EQ(brightness(0.9F, {0.0, 0.8}), 255);
}

TEST(PlotColours, TheAutomaticRangeBeginsAtTheFirstPercentileOfWhatIsDrawn) {
  PlotRaster raster{.width = 200, .height = 1, .z = std::vector<float>(200), .zstar = std::vector<float>(200, kNaN)};
  for (std::size_t k = 0; k < 200; ++k) raster.z[k] = 0.4051F + 0.001F * static_cast<float>(k);
  raster.z[0] = 0.0F;  // One stray value of 200.
  EXPECT_DOUBLE_EQ(auto_range(raster, PlotChannels::kZ).lo, 0.40);
  EXPECT_DOUBLE_EQ(auto_range(raster, PlotChannels::kBoth).lo, 0.40);
  EXPECT_DOUBLE_EQ(auto_range(raster, PlotChannels::kZstar).lo, 0.0) << "nothing to see";
  raster.z.assign(200, 1.0F);
  EXPECT_DOUBLE_EQ(auto_range(raster, PlotChannels::kZ).lo, 0.95) << "noise is not stretched";
  EXPECT_DOUBLE_EQ(auto_range(raster, PlotChannels::kZ).hi, 1.0);
}

}  // namespace
}  // namespace choreo::similarity
