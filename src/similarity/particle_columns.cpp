// SPDX-License-Identifier: Apache-2.0
#include "similarity/particle_columns.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace choreo::similarity {
namespace {

constexpr std::size_t kValues = body::kParticleValues;

// The values that mirroring keeps, then those that it turns; in order.
constexpr auto kKept = std::to_array<std::size_t>({0, 2, 3, 4, 6, 7, 10, 12, 13});
constexpr auto kTurned = std::to_array<std::size_t>({1, 5, 8, 9, 11, 14});

constexpr bool signs_agree() {
  for (const auto k : kKept) {
    if (body::kParticleMirrorSigns[k] != 1) return false;
  }
  for (const auto k : kTurned) {
    if (body::kParticleMirrorSigns[k] != -1) return false;
  }
  return kKept.size() + kTurned.size() == kValues;
}
static_assert(signs_agree());

}  // namespace

ParticleColumns::Row ParticleColumns::row_of(const body::ParticleState* state) {
  Row row;
  if (state == nullptr) {
    row.psi.fill(std::numeric_limits<float>::quiet_NaN());
    row.square = std::numeric_limits<float>::quiet_NaN();
    return row;
  }
  // Summed as `compare` does: then a state with itself divides a number by itself.
  float kept = 0;
  float turned = 0;
  for (std::size_t k = 0; k < kValues; ++k) row.psi[k] = static_cast<float>(state->psi()[k]);
  for (const auto k : kKept) kept += row.psi[k] * row.psi[k];
  for (const auto k : kTurned) turned += row.psi[k] * row.psi[k];
  row.square = kept + turned;
  return row;
}

void ParticleColumns::compare_block(const Row& query, const float* block, float* z, float* zstar) {
  std::array<float, kBlock> kept{};
  std::array<float, kBlock> turned{};
  for (const auto k : kKept) {
    for (std::size_t i = 0; i < kBlock; ++i) kept[i] += query.psi[k] * block[k * kBlock + i];
  }
  for (const auto k : kTurned) {
    for (std::size_t i = 0; i < kBlock; ++i) turned[i] += query.psi[k] * block[k * kBlock + i];
  }
  for (std::size_t i = 0; i < kBlock; ++i) {
    const float norm = std::sqrt(query.square * block[kValues * kBlock + i]);
    const float a = (kept[i] + turned[i]) / norm;
    const float b = (kept[i] - turned[i]) / norm;
    // Written so that NaN stays.
    const float a0 = a < 0 ? 0 : a;
    const float b0 = b < 0 ? 0 : b;
    z[i] = a0 > 1 ? 1 : a0;
    zstar[i] = b0 > 1 ? 1 : b0;
  }
}

ParticleColumns::ParticleColumns(std::size_t capacity)
    : capacity_(capacity),
      values_((capacity + kBlock - 1) / kBlock * kBlock * kColumns, std::numeric_limits<float>::quiet_NaN()) {}

void ParticleColumns::put(std::size_t row, const Row& state) {
  assert(row < capacity_);
  float* column = values_.data() + row / kBlock * kBlock * kColumns + row % kBlock;
  for (std::size_t k = 0; k < kValues; ++k) column[k * kBlock] = state.psi[k];
  column[kValues * kBlock] = state.square;
}

ParticleColumns::Row ParticleColumns::at(std::size_t row) const {
  assert(row < capacity_);
  const float* column = values_.data() + row / kBlock * kBlock * kColumns + row % kBlock;
  Row state;
  for (std::size_t k = 0; k < kValues; ++k) state.psi[k] = column[k * kBlock];
  state.square = column[kValues * kBlock];
  return state;
}

void ParticleColumns::compare(const Row& query, std::size_t begin, std::span<float> z, std::span<float> zstar) const {
  assert(z.size() == zstar.size() && begin + z.size() <= capacity_);
  const auto end = begin + z.size();
  for (std::size_t row = begin; row < end;) {
    // Whole blocks, whatever is asked for: the loops over them have no remainder.
    std::array<float, kBlock> straight;
    std::array<float, kBlock> mirrored;
    compare_block(query, values_.data() + row / kBlock * kBlock * kColumns, straight.data(), mirrored.data());
    const auto from = row % kBlock;
    const auto count = std::min(kBlock - from, end - row);
    std::copy_n(straight.data() + from, count, z.data() + (row - begin));
    std::copy_n(mirrored.data() + from, count, zstar.data() + (row - begin));
    row += count;
  }
}

}  // namespace choreo::similarity
