// SPDX-License-Identifier: Apache-2.0
// The fast comparison against body::similarity and body::mirror_similarity, bit by bit, for every kernel.
#include "similarity/mask_comparer.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "support/drawn_masks.hpp"
#include "support/states.hpp"

namespace choreo::similarity {
namespace {

using test::Matrices;
using test::random_states;
using test::States;

using Method = MaskComparer::Method;
constexpr std::array kMethods = {Method::kBits, Method::kRuns};

void expect_as_specified(const States& states, const AndCountKernel& kernel, Method method) {
  const MaskComparer comparer(states, kernel, method);
  ASSERT_EQ(comparer.size(), states.size());
  ASSERT_EQ(comparer.method(), method);
  Matrices got(states.size());
  comparer.compare({0, states.size()}, {0, states.size()}, got.z_view(), got.zstar_view());
  for (std::size_t i = 0; i < states.size(); ++i) {
    for (std::size_t j = 0; j < states.size(); ++j) {
      if (!states[i] || !states[j]) {
        ASSERT_TRUE(std::isnan(got.z_at(i, j)) && std::isnan(got.zstar_at(i, j))) << i << "," << j;
        continue;
      }
      ASSERT_EQ(got.z_at(i, j), float(body::similarity(*states[i], *states[j])))
          << kernel.name << " Z(" << i << "," << j << ") of " << states.size();
      ASSERT_EQ(got.zstar_at(i, j), float(body::mirror_similarity(*states[i], *states[j])))
          << kernel.name << " Z*(" << i << "," << j << ") of " << states.size();
    }
  }
}

void expect_as_specified(const States& states, const AndCountKernel& kernel) {
  for (const auto method : kMethods) expect_as_specified(states, kernel, method);
}

TEST(MaskComparer, EqualsTheSpecificationToTheLastBitForEveryKernelAndLength) {
  for (const auto& kernel : and_count_kernels()) {
    for (const std::size_t n : {0, 1, 2, 3, 31, 32, 33, 63, 64, 65, 130})
      expect_as_specified(random_states(n, 31 + n), kernel);
  }
}

TEST(MaskComparer, AllThreeShiftsOfTheMirrorAreAmongTheTestedPairs) {
  const auto states = random_states(64, 31 + 64);
  std::array<int, 3> seen{};
  for (const auto& a : states) {
    for (const auto& b : states) {
      if (!a || !b) continue;
      ++seen[std::size_t(1 + body::mirror_shift(a->remainder_x(), a->area(), b->remainder_x(), b->area()))];
    }
  }
  for (const auto count : seen) EXPECT_GT(count, 50);
}

TEST(MaskComparer, SymmetricBodiesOfEvenWidthThatFillTheCanvasAreWhollySymmetric) {
  States states;
  states.push_back(test::state_of(test::mask_of({"########", "########"})));
  states.push_back(test::state_of(test::mask_of({"########"})));
  states.push_back(test::state_of(test::mask_of({".#######", "########"})));
  states.push_back(test::state_of(test::mask_of({"#######.", "########"})));
  for (const auto& kernel : and_count_kernels()) {
    expect_as_specified(states, kernel);
    for (const auto method : kMethods) {
      const MaskComparer comparer(states, kernel, method);
      Matrices got(states.size());
      comparer.compare({0, 4}, {0, 4}, got.z_view(), got.zstar_view());
      EXPECT_EQ(got.zstar_at(0, 0), 1.0F);
      EXPECT_EQ(got.zstar_at(1, 1), 1.0F);
      EXPECT_EQ(got.zstar_at(2, 3), 1.0F);
    }
  }
}

TEST(MaskComparer, BodiesFarOffTheirCentresAreComparedAsSpecified) {
  // One long arm to the left, to the right, and single pixels: the canvas is lopsided.
  States states;
  states.push_back(test::state_of(test::mask_of({"#.....................................................###"})));
  states.push_back(test::state_of(test::mask_of({"###.....................................................#",
                                                 "###.........................................#...........#"})));
  states.push_back(test::state_of(test::mask_of({"#"})));
  states.push_back(test::state_of(test::mask_of({"##"})));
  for (const auto& kernel : and_count_kernels()) {
    expect_as_specified(states, kernel);
    for (std::size_t only = 0; only < states.size(); ++only) {
      States alone;
      alone.push_back(std::make_unique<const body::MaskState>(*states[only]));
      expect_as_specified(alone, kernel);
    }
  }
}

TEST(MaskComparer, LargeBodiesSpanManyChunks) {
  // 400 x 700 pixels are 35 KiB a string, and the sums of a line 26 KiB: more than is worked through at a time.
  std::mt19937 random(41);
  States states;
  for (int k = 0; k < 3; ++k) states.push_back(test::state_of(test::random_mask(random, {400 - k, 700}, 0.5)));
  states.push_back(test::state_of(cv::Mat(700, 400, CV_8UC1, cv::Scalar(255))));
  for (const auto& kernel : and_count_kernels()) expect_as_specified(states, kernel);
}

TEST(MaskComparer, OnlyGapsGiveOnlyNaN) {
  const States gaps(5);
  const MaskComparer comparer(gaps, choose_and_count());
  EXPECT_EQ(comparer.bytes(), 0U);
  expect_as_specified(gaps, choose_and_count());
}

TEST(MaskComparer, APartEqualsThatPartOfTheWhole) {
  const auto states = random_states(137, 51);
  for (const auto method : kMethods) {
    const MaskComparer comparer(states, choose_and_count(), method);
    Matrices whole(137);
    comparer.compare({0, 137}, {0, 137}, whole.z_view(), whole.zstar_view());
    for (const auto& [rows, cols] : {std::pair{Range{0, 1}, Range{36, 37}},
                                     {Range{3, 8}, Range{10, 21}},
                                     {Range{11, 22}, Range{4, 5}},
                                     {Range{9, 9}, Range{0, 37}},
                                     {Range{0, 37}, Range{5, 5}},
                                     {Range{90, 129}, Range{60, 66}},
                                     {Range{130, 137}, Range{30, 69}},
                                     {Range{0, 2}, Range{128, 137}}}) {
      // Written into the middle of a larger matrix, whose other places stay as they are.
      std::vector<float> z(40 * 40, -7.0F);
      std::vector<float> zstar(40 * 40, -7.0F);
      comparer.compare(rows, cols, {z.data() + 41, rows.size(), cols.size(), 40},
                       {zstar.data() + 41, rows.size(), cols.size(), 40});
      for (std::size_t i = 0; i < 39; ++i) {
        for (std::size_t j = 0; j < 39; ++j) {
          const bool inside = i < rows.size() && j < cols.size();
          const auto expected = inside ? whole.z_at(rows.begin + i, cols.begin + j) : -7.0F;
          const auto expected_star = inside ? whole.zstar_at(rows.begin + i, cols.begin + j) : -7.0F;
          ASSERT_TRUE(test::same_bits(z[41 + i * 40 + j], expected)) << i << "," << j;
          ASSERT_TRUE(test::same_bits(zstar[41 + i * 40 + j], expected_star)) << i << "," << j;
        }
      }
    }
  }
}

TEST(MaskComparer, NeedsTheStatesOnlyWhileItIsMade) {
  for (const auto method : kMethods) {
    auto states = random_states(8, 61);
    const MaskComparer comparer(states, choose_and_count(), method);
    Matrices before(8);
    comparer.compare({0, 8}, {0, 8}, before.z_view(), before.zstar_view());
    states.clear();
    Matrices after(8);
    comparer.compare({0, 8}, {0, 8}, after.z_view(), after.zstar_view());
    EXPECT_TRUE(before == after);
  }
}

TEST(MaskComparer, TheCanvasIsWhatTheBodiesOccupyAndAMargin) {
  States states;
  states.push_back(test::state_of(test::mask_of({"###", "###", "###"})));  // -1 .. 1 both ways
  states.push_back(test::state_of(test::mask_of({"#######"})));            // -3 .. 3 in row 0
  for (const auto method : kMethods) {
    EXPECT_EQ(MaskComparer(states, choose_and_count(), method).canvas(), cv::Size(7 + 2, 3));
  }
  // Two states, each a string and its mirror image.
  EXPECT_EQ(MaskComparer(states, choose_and_count(), Method::kBits).bytes(), 2 * 2 * kBitAlignment);
}

TEST(MaskComparer, BodiesAreComparedByRunsAndNoiseByBits) {
  std::mt19937 random(71);
  States noise;
  States bodies;
  for (int k = 0; k < 5; ++k) {
    noise.push_back(test::state_of(test::random_mask(random, {60, 60}, 0.5)));
    bodies.push_back(test::state_of(cv::Mat(60, 50 + k, CV_8UC1, cv::Scalar(255))));
  }
  EXPECT_EQ(MaskComparer(noise, choose_and_count()).method(), Method::kBits);
  EXPECT_EQ(MaskComparer(bodies, choose_and_count()).method(), Method::kRuns);
}

}  // namespace
}  // namespace choreo::similarity
