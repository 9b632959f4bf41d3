// SPDX-License-Identifier: Apache-2.0
#include "similarity/particle_columns.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace choreo::similarity {
namespace {

constexpr std::size_t kBlock = 64;  // Rows at a time, always all of them: the vector loop has no remainder.
constexpr std::size_t kValues = body::kParticleValues;

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
  for (std::size_t k = 0; k < kValues; ++k) {
    row.psi[k] = static_cast<float>(state->psi()[k]);
    (body::kParticleMirrorSigns[k] > 0 ? kept : turned) += row.psi[k] * row.psi[k];
  }
  row.square = kept + turned;
  return row;
}

ParticleColumns::ParticleColumns(std::size_t capacity)
    : capacity_(capacity),
      stride_(capacity + kBlock),
      values_(kColumns * stride_, std::numeric_limits<float>::quiet_NaN()) {}

void ParticleColumns::put(std::size_t row, const Row& state) {
  assert(row < capacity_);
  for (std::size_t k = 0; k < kValues; ++k) values_[k * stride_ + row] = state.psi[k];
  values_[kValues * stride_ + row] = state.square;
}

ParticleColumns::Row ParticleColumns::at(std::size_t row) const {
  assert(row < capacity_);
  Row state;
  for (std::size_t k = 0; k < kValues; ++k) state.psi[k] = values_[k * stride_ + row];
  state.square = values_[kValues * stride_ + row];
  return state;
}

void ParticleColumns::compare(const Row& query, std::size_t begin, std::span<float> z, std::span<float> zstar) const {
  assert(z.size() == zstar.size() && begin + z.size() <= capacity_);
  for (std::size_t done = 0; done < z.size(); done += kBlock) {
    const float* rows = values_.data() + begin + done;
    std::array<float, kBlock> kept{};
    std::array<float, kBlock> turned{};
    for (std::size_t k = 0; k < kValues; ++k) {
      const float value = query.psi[k];
      const float* column = rows + k * stride_;
      auto& sum = body::kParticleMirrorSigns[k] > 0 ? kept : turned;
      for (std::size_t i = 0; i < kBlock; ++i) sum[i] += value * column[i];
    }
    std::array<float, kBlock> straight;
    std::array<float, kBlock> mirrored;
    const float* squares = rows + kValues * stride_;
    for (std::size_t i = 0; i < kBlock; ++i) {
      const float norm = std::sqrt(query.square * squares[i]);
      const float a = (kept[i] + turned[i]) / norm;
      const float b = (kept[i] - turned[i]) / norm;
      // Written so that NaN stays.
      const float a0 = a < 0 ? 0 : a;
      const float b0 = b < 0 ? 0 : b;
      straight[i] = a0 > 1 ? 1 : a0;
      mirrored[i] = b0 > 1 ? 1 : b0;
    }
    const auto count = std::ptrdiff_t(std::min(kBlock, z.size() - done));
    std::copy_n(straight.begin(), count, z.begin() + std::ptrdiff_t(done));
    std::copy_n(mirrored.begin(), count, zstar.begin() + std::ptrdiff_t(done));
  }
}

}  // namespace choreo::similarity
