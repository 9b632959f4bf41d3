// SPDX-License-Identifier: Apache-2.0
// The online history against the batch comparison and the specification, bit by bit, for every kernel.
#include "similarity/mask_history.hpp"

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/error.hpp"
#include "similarity/mask_comparer.hpp"
#include "support/allocations.hpp"
#include "support/drawn_masks.hpp"
#include "support/states.hpp"

namespace choreo::similarity {
namespace {

using test::same_bits;
using test::States;

// A picture of that size with a body somewhere in it: what the history is made for. Every seventh is a gap.
States bodies_in(cv::Size picture, std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  States states;
  for (std::size_t k = 0; k < n; ++k) {
    if (k % 7 == 5) {
      states.push_back(nullptr);
      continue;
    }
    const cv::Size size(1 + int(random() % unsigned(picture.width)), 1 + int(random() % unsigned(picture.height)));
    const cv::Point corner(int(random() % unsigned(picture.width - size.width + 1)),
                           int(random() % unsigned(picture.height - size.height + 1)));
    cv::Mat mask = cv::Mat::zeros(picture, CV_8UC1);
    const double density = 0.02 + 0.9 * double(random() % 100) / 100;
    test::random_mask(random, size, density).copyTo(mask(cv::Rect(corner, size)));
    states.push_back(test::state_of(mask));
  }
  return states;
}

// What an append gives; beyond size() nothing may be written.
test::HistoryRow append(MaskHistory& history, const body::MaskState* state) {
  const float untouched = -7.0F;
  test::HistoryRow row{std::vector<float>(history.capacity() + 3, untouched),
                       std::vector<float>(history.capacity() + 3, untouched)};
  history.append(state, row.z, row.zstar);
  for (auto i = history.size(); i < row.z.size(); ++i) {
    EXPECT_EQ(row.z[i], untouched);
    EXPECT_EQ(row.zstar[i], untouched);
  }
  row.z.resize(history.size());
  row.zstar.resize(history.size());
  return row;
}

void expect_as_specified(const test::HistoryRow& row, std::span<const std::unique_ptr<const body::MaskState>> seen,
                         const std::string& kernel) {
  ASSERT_EQ(row.z.size(), seen.size());
  const auto& own = seen.back();
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (!own || !seen[i]) {
      ASSERT_TRUE(std::isnan(row.z[i]) && std::isnan(row.zstar[i])) << kernel << ", " << i << " of " << seen.size();
      continue;
    }
    ASSERT_EQ(row.z[i], float(body::similarity(*own, *seen[i]))) << kernel << ", Z, " << i << " of " << seen.size();
    ASSERT_EQ(row.zstar[i], float(body::mirror_similarity(*own, *seen[i])))
        << kernel << ", Z*, " << i << " of " << seen.size();
  }
}

// Appends all, checking every row against the specification.
void expect_rows_as_specified(cv::Size picture, const States& states, std::size_t capacity,
                              const AndCountKernel& kernel) {
  MaskHistory history(picture, capacity, kernel);
  for (std::size_t t = 0; t < states.size(); ++t) {
    const auto row = append(history, states[t].get());
    const auto oldest = t + 1 > capacity ? t + 1 - capacity : 0;
    ASSERT_EQ(history.size(), t + 1 - oldest);
    expect_as_specified(row, std::span(states).subspan(oldest, t + 1 - oldest), kernel.name);
    if (testing::Test::HasFatalFailure()) return;
  }
}

cv::Mat points(cv::Size picture, const std::vector<cv::Rect>& parts) {
  cv::Mat mask = cv::Mat::zeros(picture, CV_8UC1);
  for (const auto& part : parts) mask(part).setTo(255);
  return mask;
}

TEST(MaskHistory, RowsEqualTheSpecificationForEveryKernelAndOddPictureSizes) {
  for (const auto& kernel : and_count_kernels()) {
    unsigned seed = 0;
    for (const auto picture : {cv::Size(1, 1),
                               {2, 3},
                               {31, 7},
                               {32, 5},
                               {33, 40},
                               {63, 9},
                               {64, 64},
                               {65, 20},
                               {100, 1},
                               {1, 100},
                               {160, 120}}) {
      expect_rows_as_specified(picture, bodies_in(picture, 24, ++seed), 30, kernel);
      ASSERT_FALSE(HasFatalFailure()) << picture.width << " x " << picture.height;
    }
  }
}

TEST(MaskHistory, RowsEqualThoseOfTheBatchToTheLastBit) {
  const cv::Size picture(90, 70);
  const auto states = bodies_in(picture, 60, 101);
  for (const auto& kernel : and_count_kernels()) {
    test::Matrices batch(states.size());
    MaskComparer(states, kernel).compare({0, 60}, {0, 60}, batch.z_view(), batch.zstar_view());
    MaskHistory history(picture, 60, kernel);
    for (std::size_t t = 0; t < states.size(); ++t) {
      const auto row = append(history, states[t].get());
      for (std::size_t i = 0; i <= t; ++i) {
        ASSERT_TRUE(same_bits(row.z[i], batch.z_at(t, i))) << kernel.name << " " << t << "," << i;
        ASSERT_TRUE(same_bits(row.zstar[i], batch.zstar_at(t, i))) << kernel.name << " " << t << "," << i;
      }
    }
  }
}

TEST(MaskHistory, TheTestedPairsHaveAllThreeShiftsOfTheMirror) {
  const auto states = bodies_in({90, 70}, 60, 101);
  std::array<int, 3> seen{};
  for (const auto& a : states) {
    for (const auto& b : states) {
      if (!a || !b) continue;
      ++seen[std::size_t(1 + body::mirror_shift(a->remainder_x(), a->area(), b->remainder_x(), b->area()))];
    }
  }
  for (const auto count : seen) EXPECT_GT(count, 50);
}

TEST(MaskHistory, NoPixelIsLostWhereABodyReachesFromCornerToCorner) {
  // A heavy part in one corner pulls the centroid there; one far pixel stretches the box to the opposite corner.
  for (const auto picture : {cv::Size(64, 48), cv::Size(70, 50), cv::Size(95, 33), cv::Size(97, 3)}) {
    const int w = picture.width;
    const int h = picture.height;
    const cv::Rect top_left(0, 0, w / 3, h / 3);
    const cv::Rect bottom_right(w - w / 3, h - h / 3, w / 3, h / 3);
    const cv::Rect first(0, 0, 1, 1);
    const cv::Rect last(w - 1, h - 1, 1, 1);
    States states;
    states.push_back(test::state_of(points(picture, {top_left, last})));
    states.push_back(test::state_of(points(picture, {bottom_right, first})));
    states.push_back(test::state_of(points(picture, {first, last})));
    states.push_back(test::state_of(points(picture, {{w - 1, 0, 1, 1}, {0, h - 1, 1, 1}})));
    states.push_back(test::state_of(points(picture, {cv::Rect({0, 0}, picture)})));
    states.push_back(test::state_of(points(picture, {first})));
    states.push_back(test::state_of(points(picture, {last})));
    states.push_back(test::state_of(points(picture, {{0, h / 2, w, 1}})));
    states.push_back(test::state_of(points(picture, {{w / 2, 0, 1, h}})));
    for (const auto& kernel : and_count_kernels()) {
      expect_rows_as_specified(picture, states, states.size(), kernel);
      const std::size_t two = 2;
      expect_rows_as_specified(picture, states, two, kernel);
    }
  }
}

TEST(MaskHistory, BodiesThatShareNoLineHaveNothingInCommon) {
  // Boxes hold their centroids, so this takes bodies that are hollow between their parts.
  const cv::Size picture(40, 60);
  States states;
  states.push_back(test::state_of(points(picture, {{5, 30, 20, 1}})));
  states.push_back(test::state_of(points(picture, {{5, 10, 20, 3}, {5, 40, 20, 3}})));
  for (const auto& kernel : and_count_kernels()) expect_rows_as_specified(picture, states, 4, kernel);
}

TEST(MaskHistory, ASlotUsedAgainForASmallerBodyKeepsNothingOfTheLargerOne) {
  const cv::Size picture(200, 60);
  const auto large = test::state_of(points(picture, {cv::Rect({0, 0}, picture)}));
  const auto small = test::state_of(points(picture, {{50, 20, 3, 3}}));
  for (const auto& kernel : and_count_kernels()) {
    MaskHistory history(picture, 2, kernel);
    append(history, large.get());
    append(history, large.get());
    append(history, small.get());
    append(history, small.get());
    const auto row = append(history, large.get());
    EXPECT_EQ(row.z[0], float(body::similarity(*large, *small))) << kernel.name;
    EXPECT_EQ(row.z[1], 1.0F) << kernel.name;
  }
}

TEST(MaskHistory, AFullRingForgetsTheOldest) {
  const cv::Size picture(50, 40);
  const auto states = bodies_in(picture, 40, 111);
  for (const std::size_t capacity : {1, 2, 3, 13}) {
    expect_rows_as_specified(picture, states, capacity, choose_and_count());
  }
}

TEST(MaskHistory, RowsCanBeDroppedByAge) {
  const cv::Size picture(50, 40);
  const auto states = bodies_in(picture, 60, 121);
  for (const auto& kernel : and_count_kernels()) {
    MaskHistory history(picture, 12, kernel);
    std::mt19937 random(122);
    std::size_t oldest = 0;
    for (std::size_t t = 0; t < states.size(); ++t) {
      const auto row = append(history, states[t].get());
      oldest = std::max(oldest, t + 1 > 12 ? t + 1 - 12 : 0);
      expect_as_specified(row, std::span(states).subspan(oldest, t + 1 - oldest), kernel.name);
      if (HasFatalFailure()) return;
      const auto drop = t % 5 == 4 ? random() % (history.size() + 1) : 0;
      history.drop_oldest(drop);
      oldest += drop;
      ASSERT_EQ(history.size(), t + 1 - oldest);
    }
  }
}

TEST(MaskHistory, MoreThanThereIsCanBeDropped) {
  MaskHistory history({4, 4}, 3, choose_and_count());
  history.drop_oldest(2);
  EXPECT_EQ(history.size(), 0U);
  const auto state = test::state_of(test::mask_of({"####", ".##.", ".##.", "...."}));
  append(history, state.get());
  history.drop_oldest(7);
  EXPECT_EQ(history.size(), 0U);
  EXPECT_EQ(append(history, state.get()).z, std::vector<float>{1.0F});
}

TEST(MaskHistory, AHistoryOfGapsGivesNaN) {
  MaskHistory history({8, 8}, 3, choose_and_count());
  for (std::size_t t = 0; t < 5; ++t) {
    const auto row = append(history, nullptr);
    ASSERT_EQ(row.z.size(), std::min<std::size_t>(t + 1, 3));
    for (const auto value : row.z) EXPECT_TRUE(std::isnan(value));
    for (const auto value : row.zstar) EXPECT_TRUE(std::isnan(value));
    EXPECT_EQ(history.bytes_read(), 0U);
  }
}

TEST(MaskHistory, MemoryIsFixedOnceItIsMade) {
  const cv::Size picture(160, 120);
  const auto states = bodies_in(picture, 50, 131);
  MaskHistory history(picture, 20, choose_and_count());
  const auto memory = history.memory_bytes();
  std::vector<float> z(20);
  std::vector<float> zstar(20);
  ASSERT_GT(test::allocations(), 0U) << "none is counted";
  const auto before = test::allocations();
  for (const auto& state : states) {
    history.append(state.get(), z, zstar);
    if (history.size() == 15) history.drop_oldest(3);
  }
  EXPECT_EQ(test::allocations(), before);
  EXPECT_EQ(history.memory_bytes(), memory);
}

TEST(MaskHistory, MemoryGrowsByBytesPerRowWithTheCapacity) {
  const MaskHistory small({160, 120}, 10, choose_and_count());
  const MaskHistory large({160, 120}, 1010, choose_and_count());
  EXPECT_EQ(large.memory_bytes() - small.memory_bytes(), 1000 * large.bytes_per_row());
  EXPECT_EQ(small.bytes_per_row(), large.bytes_per_row());
  // 160 pixels begin anywhere in their first cell of 32: six cells of four bytes a line.
  EXPECT_LT(small.bytes_per_row(), 6 * 4 * 120 + 150);
}

TEST(MaskHistory, ReadsOnceWhatBothBodiesOccupy) {
  // 20 x 20 pixels about the centroid lie in two cells: 160 bytes, padded to the alignment.
  const cv::Size picture(640, 480);
  const auto state = test::state_of(points(picture, {{300, 200, 20, 20}}));
  MaskHistory history(picture, 8, choose_and_count());
  for (std::size_t t = 1; t <= 8; ++t) {
    append(history, state.get());
    EXPECT_EQ(history.bytes_read(), t * padded(2 * 4 * 20));
  }
}

TEST(MaskHistory, ABodyLargerThanThePictureIsRefusedAndChangesNothing) {
  MaskHistory history({8, 4}, 3, choose_and_count());
  const auto wide = test::state_of(points({9, 1}, {{0, 0, 9, 1}}));
  const auto high = test::state_of(points({1, 5}, {{0, 0, 1, 5}}));
  std::array<float, 3> z{};
  EXPECT_THROW(history.append(wide.get(), z, z), Error);
  EXPECT_THROW(history.append(high.get(), z, z), Error);
  EXPECT_EQ(history.size(), 0U);
}

}  // namespace
}  // namespace choreo::similarity
