// SPDX-License-Identifier: Apache-2.0
#include "vision/fast_exp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace choreo::vision {
namespace {

TEST(FastExp, IsWithinTwoTenMillionthsOfTheTruth) {
  double worst = 0;
  for (int i = -800'000; i <= 800'000; ++i) {
    const auto x = static_cast<float>(i * 1e-4);
    const double truth = std::exp(double{x});
    worst = std::max(worst, std::abs(double{fast_exp(x)} - truth) / truth);
  }
  EXPECT_LT(worst, 2e-7);
}

TEST(FastExp, OfZeroIsExactlyOne) {
  EXPECT_EQ(fast_exp(0.0F), 1.0F);
  EXPECT_EQ(fast_exp(-0.0F), 1.0F);
}

TEST(FastExp, BeyondItsRangeIsThatOfTheRangesEnd) {
  const auto infinity = std::numeric_limits<float>::infinity();
  for (const float x : {81.0F, 1e30F, infinity}) EXPECT_EQ(fast_exp(x), fast_exp(80.0F));
  for (const float x : {-81.0F, -1e30F, -infinity}) EXPECT_EQ(fast_exp(x), fast_exp(-80.0F));
}

}  // namespace
}  // namespace choreo::vision
