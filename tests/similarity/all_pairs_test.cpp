// SPDX-License-Identifier: Apache-2.0
#include "similarity/all_pairs.hpp"

#include <atomic>
#include <cmath>
#include <mutex>
#include <set>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "similarity/mask_comparer.hpp"
#include "support/states.hpp"

namespace choreo::similarity {
namespace {

using test::Matrices;
using test::random_states;

/// A comparison whose value says which pair was asked for, and that counts how often.
class Pairs final : public Comparer {
 public:
  explicit Pairs(std::size_t n) : n_(n) {}
  [[nodiscard]] std::size_t size() const override { return n_; }
  void compare(Range rows, Range cols, MatrixView<float> z, MatrixView<float> zstar) const override {
    if (stop_at_first_ != nullptr) stop_at_first_->request_stop();
    compared_ += rows.size() * cols.size();
    for (std::size_t i = rows.begin; i < rows.end; ++i) {
      for (std::size_t j = cols.begin; j < cols.end; ++j) {
        z(i - rows.begin, j - cols.begin) = float(std::min(i, j) * n_ + std::max(i, j));
        zstar(i - rows.begin, j - cols.begin) = -float(std::min(i, j) * n_ + std::max(i, j));
      }
    }
  }
  [[nodiscard]] std::size_t compared() const { return compared_; }
  void stop_at_first(std::stop_source& source) { stop_at_first_ = &source; }

 private:
  std::size_t n_;
  std::stop_source* stop_at_first_ = nullptr;
  mutable std::atomic<std::size_t> compared_{0};
};

TEST(AllPairs, EveryPairIsWrittenToBothItsPlaces) {
  for (const std::size_t n : {0, 1, 2, 63, 64, 65, 128, 200}) {
    Matrices m(n);
    EXPECT_TRUE(all_pairs(Pairs(n), m.z_view(), m.zstar_view()));
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) {
        ASSERT_EQ(m.z_at(i, j), float(std::min(i, j) * n + std::max(i, j))) << i << "," << j << " of " << n;
        ASSERT_EQ(m.zstar_at(i, j), -m.z_at(i, j));
      }
    }
  }
}

TEST(AllPairs, UsesTheMatrixsSymmetry) {
  const std::size_t n = 640;
  const Pairs pairs(n);
  Matrices m(n);
  EXPECT_TRUE(all_pairs(pairs, m.z_view(), m.zstar_view()));
  EXPECT_LT(pairs.compared(), n * n * 6 / 10);
}

TEST(AllPairs, WritesIntoAPartOfALargerMatrix) {
  const std::size_t n = 70;
  const std::size_t stride = 90;
  std::vector<float> z(n * stride, 0.5F);
  std::vector<float> zstar(n * stride, 0.5F);
  EXPECT_TRUE(all_pairs(Pairs(n), {z.data(), n, n, stride}, {zstar.data(), n, n, stride}));
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) EXPECT_EQ(z[i * stride + j], float(std::min(i, j) * n + std::max(i, j)));
    for (std::size_t j = n; j < stride; ++j) EXPECT_EQ(z[i * stride + j], 0.5F);
  }
}

TEST(AllPairs, MasksGiveASymmetricMatrixWithUnitDiagonalAndNaNForGaps) {
  const auto states = random_states(150, 71);
  const MaskComparer comparer(states, choose_and_count());
  Matrices m(150);
  ASSERT_TRUE(all_pairs(comparer, m.z_view(), m.zstar_view()));
  for (std::size_t i = 0; i < 150; ++i) {
    if (states[i]) {
      EXPECT_EQ(m.z_at(i, i), 1.0F);
    }
    for (std::size_t j = 0; j < 150; ++j) {
      ASSERT_TRUE(test::same_bits(m.z_at(i, j), m.z_at(j, i)));
      ASSERT_TRUE(test::same_bits(m.zstar_at(i, j), m.zstar_at(j, i)));
      ASSERT_EQ(std::isnan(m.z_at(i, j)), !states[i] || !states[j]);
      ASSERT_EQ(std::isnan(m.zstar_at(i, j)), !states[i] || !states[j]);
    }
  }
}

TEST(AllPairs, OneThreadGivesTheSameBytesAsMany) {
  const auto states = random_states(200, 72);
  const MaskComparer comparer(states, choose_and_count());
  Matrices one(200);
  {
    const tbb::global_control single(tbb::global_control::max_allowed_parallelism, 1);
    ASSERT_TRUE(all_pairs(comparer, one.z_view(), one.zstar_view()));
  }
  for (int repeat = 0; repeat < 3; ++repeat) {
    const tbb::global_control several(tbb::global_control::max_allowed_parallelism, 8);
    Matrices many(200);
    ASSERT_TRUE(all_pairs(comparer, many.z_view(), many.zstar_view()));
    EXPECT_TRUE(one == many);
  }
}

TEST(PairsByBands, EveryRowComesOnceInOrderAgainstAllUpToItsBandsEnd) {
  for (const std::size_t n : {0, 1, 63, 64, 65, 255, 256, 257, 1000}) {
    std::size_t next = 0;
    EXPECT_TRUE(pairs_by_bands(Pairs(n), [&](Range rows, MatrixView<const float> z, MatrixView<const float> zstar) {
      EXPECT_EQ(rows.begin, next);
      next = rows.end;
      ASSERT_EQ(z.rows(), rows.size());
      ASSERT_EQ(z.cols(), rows.end);
      ASSERT_EQ(zstar.cols(), rows.end);
      for (std::size_t i = rows.begin; i < rows.end; ++i) {
        for (std::size_t j = 0; j < rows.end; ++j) {
          ASSERT_EQ(z(i - rows.begin, j), float(std::min(i, j) * n + std::max(i, j))) << i << "," << j << " of " << n;
          ASSERT_EQ(zstar(i - rows.begin, j), -z(i - rows.begin, j));
        }
      }
    }));
    EXPECT_EQ(next, n);
  }
}

TEST(PairsByBands, NoBandIsGivenIncomplete) {
  std::stop_source stop;
  Pairs pairs(1000);
  pairs.stop_at_first(stop);
  int bands = 0;
  EXPECT_FALSE(pairs_by_bands(
      pairs, [&](auto...) { ++bands; }, stop.get_token()));
  EXPECT_EQ(bands, 0);
}

TEST(AllPairs, AStopBeforeTheStartComparesNothing) {
  std::stop_source stop;
  stop.request_stop();
  const Pairs pairs(100);
  Matrices m(100);
  EXPECT_FALSE(all_pairs(pairs, m.z_view(), m.zstar_view(), stop.get_token()));
  EXPECT_EQ(pairs.compared(), 0U);
}

TEST(AllPairs, AStopOnTheWayEndsItEarlyWithFalse) {
  const tbb::global_control single(tbb::global_control::max_allowed_parallelism, 1);
  std::stop_source stop;
  Pairs pairs(1000);
  pairs.stop_at_first(stop);
  Matrices m(1000);
  EXPECT_FALSE(all_pairs(pairs, m.z_view(), m.zstar_view(), stop.get_token()));
  EXPECT_LE(pairs.compared(), std::size_t{64 * 64}) << "one thread ends after the tile it was at";
}

TEST(AllPairs, ProgressEndsAtOneAndNeverLeavesItsRange) {
  std::mutex mutex;
  std::multiset<double> said;
  Matrices m(1000);
  ASSERT_TRUE(all_pairs(Pairs(1000), m.z_view(), m.zstar_view(), {}, [&](double share) {
    const std::scoped_lock lock(mutex);
    said.insert(share);
  }));
  ASSERT_GE(said.size(), 2U);
  EXPECT_GT(*said.begin(), 0.0);
  EXPECT_EQ(*said.rbegin(), 1.0);
  EXPECT_EQ(said.count(1.0), 1U);
}

}  // namespace
}  // namespace choreo::similarity
