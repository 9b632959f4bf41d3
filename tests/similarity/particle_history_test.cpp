// SPDX-License-Identifier: Apache-2.0
// Particle states online and in batch: the specification to 1e-6, each other to the last bit.
#include "similarity/particle_history.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "similarity/all_pairs.hpp"
#include "similarity/particle_comparer.hpp"
#include "support/allocations.hpp"
#include "support/particles.hpp"
#include "support/states.hpp"

namespace choreo::similarity {
namespace {

using body::ParticleState;
using test::same_bits;

const ParticleState* pointer(const std::optional<ParticleState>& state) { return state ? &*state : nullptr; }

test::HistoryRow append(ParticleHistory& history, const ParticleState* state) {
  const auto rows = std::min(history.size() + 1, history.capacity());
  test::HistoryRow row{std::vector<float>(rows), std::vector<float>(rows)};
  history.append(state, row.z, row.zstar);
  return row;
}

test::Matrices compared(const ParticleComparer& comparer) {
  test::Matrices m(comparer.size());
  comparer.compare({0, m.n}, {0, m.n}, m.z_view(), m.zstar_view());
  return m;
}

TEST(ParticleComparer, GivesTheSpecificationToAMillionth) {
  const auto states = test::random_particle_sequence(150, 1);
  const auto m = compared(ParticleComparer(states));
  for (std::size_t i = 0; i < m.n; ++i) {
    for (std::size_t j = 0; j < m.n; ++j) {
      if (!states[i] || !states[j]) {
        EXPECT_TRUE(std::isnan(m.z_at(i, j)) && std::isnan(m.zstar_at(i, j)));
        continue;
      }
      ASSERT_NEAR(m.z_at(i, j), body::similarity(*states[i], *states[j]), 1e-6);
      ASSERT_NEAR(m.zstar_at(i, j), body::mirror_similarity(*states[i], *states[j]), 1e-6);
    }
  }
}

TEST(ParticleComparer, IsSymmetricWithAUnitDiagonalToTheLastBit) {
  const auto states = test::random_particle_sequence(150, 2);
  const auto m = compared(ParticleComparer(states));
  for (std::size_t i = 0; i < m.n; ++i) {
    if (states[i]) {
      EXPECT_EQ(m.z_at(i, i), 1.0F);
    }
    for (std::size_t j = 0; j < i; ++j) {
      ASSERT_TRUE(same_bits(m.z_at(i, j), m.z_at(j, i)));
      ASSERT_TRUE(same_bits(m.zstar_at(i, j), m.zstar_at(j, i)));
    }
  }
}

TEST(ParticleComparer, GivesTheSameBitsInBlocksOfEverySize) {
  const auto states = test::random_particle_sequence(140, 3);
  const ParticleComparer comparer(states);
  const auto whole = compared(comparer);
  for (const std::size_t width : {1U, 3U, 63U, 64U, 65U, 127U}) {
    test::Matrices blocks(comparer.size());
    for (std::size_t i = 0; i < blocks.n; i += 7) {
      for (std::size_t j = 0; j < blocks.n; j += width) {
        const Range rows{i, std::min(i + 7, blocks.n)};
        const Range cols{j, std::min(j + width, blocks.n)};
        const auto part = [&](std::vector<float>& values) {
          return MatrixView<float>(values.data() + i * blocks.n + j, rows.size(), cols.size(), blocks.n);
        };
        comparer.compare(rows, cols, part(blocks.z), part(blocks.zstar));
      }
    }
    EXPECT_TRUE(blocks == whole) << width;
  }
}

TEST(ParticleComparer, OfNothingHasSizeZero) {
  const ParticleComparer comparer({});
  EXPECT_EQ(comparer.size(), 0U);
  comparer.compare({0, 0}, {0, 0}, {}, {});
}

TEST(ParticleHistory, RowsEqualThoseOfTheBatchToTheLastBit) {
  const auto states = test::random_particle_sequence(200, 4);
  const auto batch = compared(ParticleComparer(states));
  for (const std::size_t capacity : {1U, 2U, 13U, 64U, 65U, 200U, 500U}) {
    ParticleHistory history(capacity);
    for (std::size_t t = 0; t < states.size(); ++t) {
      const auto row = append(history, pointer(states[t]));
      const auto n = std::min(t + 1, capacity);
      ASSERT_EQ(history.size(), n);
      for (std::size_t k = 0; k < n; ++k) {
        ASSERT_TRUE(same_bits(row.z[k], batch.z_at(t, t + 1 - n + k))) << capacity << ": " << t << ", " << k;
        ASSERT_TRUE(same_bits(row.zstar[k], batch.zstar_at(t, t + 1 - n + k))) << capacity << ": " << t << ", " << k;
      }
    }
  }
}

TEST(ParticleHistory, RowsCanBeDroppedByAge) {
  const auto states = test::random_particle_sequence(90, 5);
  const auto batch = compared(ParticleComparer(states));
  ParticleHistory history(12);
  std::mt19937 random(6);
  std::size_t oldest = 0;
  for (std::size_t t = 0; t < states.size(); ++t) {
    const auto row = append(history, pointer(states[t]));
    oldest = std::max(oldest, t + 1 > 12 ? t + 1 - 12 : 0);
    ASSERT_EQ(row.z.size(), t + 1 - oldest);
    for (std::size_t k = 0; k < row.z.size(); ++k) ASSERT_TRUE(same_bits(row.z[k], batch.z_at(t, oldest + k)));
    const auto drop = t % 5 == 4 ? random() % (history.size() + 1) : 0;
    history.drop_oldest(drop);
    oldest += drop;
    ASSERT_EQ(history.size(), t + 1 - oldest);
  }
  history.drop_oldest(1000);
  EXPECT_EQ(history.size(), 0U);
}

TEST(ParticleHistory, WhatIsRememberedIsComparedLater) {
  const auto states = test::random_particle_sequence(3, 7);
  ParticleHistory history(5);
  history.remember(pointer(states[0]));
  history.remember(nullptr);
  const auto row = append(history, pointer(states[2]));
  ASSERT_EQ(row.z.size(), 3U);
  EXPECT_NEAR(row.z[0], body::similarity(*states[0], *states[2]), 1e-6);
  EXPECT_TRUE(std::isnan(row.z[1]));
  EXPECT_EQ(row.z[2], 1.0F);
}

TEST(ParticleHistory, WhatLiesBeyondARowStaysAsItIs) {
  const auto states = test::random_particle_sequence(2, 8);
  ParticleHistory history(50);
  std::vector<float> z(70, -1);
  std::vector<float> zstar(70, -1);
  history.append(pointer(states[0]), z, zstar);
  EXPECT_EQ(z[0], 1.0F);
  for (std::size_t k = 1; k < z.size(); ++k) EXPECT_TRUE(z[k] == -1 && zstar[k] == -1);
}

TEST(ParticleHistory, MemoryIsFixedAndGrowsByBytesPerRowWithTheCapacity) {
  const auto states = test::random_particle_sequence(60, 9);
  ParticleHistory history(20);
  const auto memory = history.memory_bytes();
  std::vector<float> z(20);
  std::vector<float> zstar(20);
  ASSERT_GT(test::allocations(), 0U) << "none is counted";
  const auto before = test::allocations();
  for (const auto& state : states) history.append(pointer(state), z, zstar);
  EXPECT_EQ(test::allocations(), before);
  EXPECT_EQ(history.memory_bytes(), memory);
  EXPECT_EQ(ParticleHistory(1620).memory_bytes() - memory, 1600 * history.bytes_per_row());
}

}  // namespace
}  // namespace choreo::similarity
