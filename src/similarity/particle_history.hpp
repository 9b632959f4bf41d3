// SPDX-License-Identifier: Apache-2.0
// The online history of particle states.
#pragma once

#include <cstddef>
#include <span>

#include "body/particle_state.hpp"
#include "similarity/history.hpp"
#include "similarity/particle_columns.hpp"

namespace choreo::similarity {

/// A ring of particle states: 64 bytes a state.
class ParticleHistory final : public History {
 public:
  /// @param capacity  states, at least 1.
  explicit ParticleHistory(std::size_t capacity);

  [[nodiscard]] std::size_t capacity() const override { return columns_.capacity(); }
  [[nodiscard]] std::size_t size() const override { return size_; }
  [[nodiscard]] std::size_t bytes_per_row() const override { return ParticleColumns::bytes_per_row(); }
  [[nodiscard]] std::size_t memory_bytes() const override { return columns_.bytes(); }
  void drop_oldest(std::size_t count) override;

  /// Appends a state, dropping the oldest where the ring is full, and compares it with all that remain.
  ///
  /// z[i] = Z(state, i-th oldest) and zstar[i] likewise, i = 0 to size() - 1, the last the state with itself; NaN where
  /// either is a gap.
  /// @param state  nullptr: a gap.
  /// @param z, zstar  at least min(size() + 1, capacity()) floats; what lies beyond stays as it is.
  /// @cost O(size); no allocation.
  void append(const body::ParticleState* state, std::span<float> z, std::span<float> zstar);

  /// Appends a state, or a gap, without comparing it: for a history that begins with what is known already.
  void remember(const body::ParticleState* state) { take(ParticleColumns::row_of(state)); }

 private:
  void take(const ParticleColumns::Row& row);

  ParticleColumns columns_;
  std::size_t first_ = 0;  // Row of the oldest state.
  std::size_t size_ = 0;
};

}  // namespace choreo::similarity
