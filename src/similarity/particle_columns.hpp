// SPDX-License-Identifier: Apache-2.0
// Particle states laid out for comparing one with many: the one place where their pairs become Z and Z*.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "body/particle_state.hpp"

namespace choreo::similarity {

/// A table of states in single precision, in blocks of 16 rows: in a block one column a value of Psi, and one for
/// |Psi|^2, so that 16 pairs are summed at once and the table is read from end to end.
///
/// Z and Z* of a pair are sums in one fixed order, the same wherever in the table the two lie and how many are asked
/// for at once; a state with itself gives exactly 1. They differ from `body::similarity` by less than 1e-6.
class ParticleColumns {
 public:
  /// One state as it is compared; NaN throughout for a gap.
  struct Row {
    std::array<float, body::kParticleValues> psi{};
    float square = 0;  ///< |Psi|^2.
  };
  [[nodiscard]] static Row row_of(const body::ParticleState* state);

  /// @param capacity  rows, all gaps at first.
  explicit ParticleColumns(std::size_t capacity);

  [[nodiscard]] std::size_t capacity() const { return capacity_; }
  [[nodiscard]] static std::size_t bytes_per_row() { return kColumns * sizeof(float); }
  [[nodiscard]] std::size_t bytes() const { return values_.size() * sizeof(float); }

  void put(std::size_t row, const Row& state);
  [[nodiscard]] Row at(std::size_t row) const;

  /// z[i] = Z(query, row begin + i), zstar[i] likewise, for all of z; NaN where either is a gap.
  /// @param z, zstar  of one length; begin + length at most `capacity()`.
  void compare(const Row& query, std::size_t begin, std::span<float> z, std::span<float> zstar) const;

 private:
  static constexpr std::size_t kColumns = body::kParticleValues + 1;

  static constexpr std::size_t kBlock = 16;

  static void compare_block(const Row& query, const float* block, float* z, float* zstar);

  std::size_t capacity_;
  std::vector<float> values_;
};

}  // namespace choreo::similarity
