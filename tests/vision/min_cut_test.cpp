// SPDX-License-Identifier: Apache-2.0
// The cut, against all the cuts there are.
#include "vision/min_cut.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace choreo::vision {
namespace {

TEST(MinCut, ANodeGoesWhereItIsCheaper) {
  MinCut graph(3);
  graph.add_cost(0, 5, 0);
  graph.add_cost(1, 0, 5);
  graph.solve();
  EXPECT_TRUE(graph.with_source(0));
  EXPECT_FALSE(graph.with_source(1));
  EXPECT_FALSE(graph.with_source(2)) << "what could go either way goes with the sink";
}

TEST(MinCut, AStrongJoinOverrulesAWeakWish) {
  MinCut graph(2);
  graph.add_cost(0, 9, 0);
  graph.add_cost(1, 0, 2);
  graph.join(0, 1, 5);
  graph.solve();
  EXPECT_TRUE(graph.with_source(1));
}

TEST(MinCut, NoOtherCutOfARandomGraphIsCheaper) {
  constexpr int kNodes = 10;
  std::mt19937 random(7);
  const auto below = [&](unsigned most) { return static_cast<int>(random() % most); };
  for (int round = 0; round < 300; ++round) {
    std::array<std::array<int, 2>, kNodes> costs{};
    std::vector<std::array<int, 3>> joins;
    MinCut graph(kNodes);
    for (int n = 0; n < kNodes; ++n) {
      costs[std::size_t(n)] = {below(20), below(20)};
      graph.add_cost(n, costs[std::size_t(n)][0], costs[std::size_t(n)][1]);
    }
    for (int k = 0; k < 18; ++k) {
      const int a = below(kNodes);
      const int b = (a + 1 + below(kNodes - 1)) % kNodes;
      joins.push_back({a, b, below(15)});
      graph.join(a, b, joins.back()[2]);
    }
    graph.solve();
    const auto energy = [&](unsigned source) {
      int sum = 0;
      for (unsigned n = 0; n < kNodes; ++n) sum += costs[n][(source >> n & 1U) != 0 ? 1 : 0];
      for (const auto& [a, b, weight] : joins) {
        if ((source >> unsigned(a) & 1U) != (source >> unsigned(b) & 1U)) sum += weight;
      }
      return sum;
    };
    unsigned found = 0;
    for (unsigned n = 0; n < kNodes; ++n) found |= graph.with_source(static_cast<int>(n)) ? 1U << n : 0U;
    int least = energy(0);
    for (unsigned source = 1; source < 1U << kNodes; ++source) least = std::min(least, energy(source));
    ASSERT_EQ(energy(found), least) << "round " << round;
  }
}

}  // namespace
}  // namespace choreo::vision
