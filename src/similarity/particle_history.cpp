// SPDX-License-Identifier: Apache-2.0
#include "similarity/particle_history.hpp"

#include <algorithm>
#include <cassert>

namespace choreo::similarity {

ParticleHistory::ParticleHistory(std::size_t capacity) : columns_(capacity) { assert(capacity >= 1); }

void ParticleHistory::drop_oldest(std::size_t count) {
  count = std::min(count, size_);
  first_ = (first_ + count) % capacity();
  size_ -= count;
}

void ParticleHistory::take(const ParticleColumns::Row& row) {
  if (size_ == capacity()) drop_oldest(1);
  columns_.put((first_ + size_) % capacity(), row);
  ++size_;
}

void ParticleHistory::append(const body::ParticleState* state, std::span<float> z, std::span<float> zstar) {
  const auto row = ParticleColumns::row_of(state);
  take(row);
  assert(z.size() >= size_ && zstar.size() >= size_);
  // Up to the end of the ring, then from its begin.
  const auto before = std::min(size_, capacity() - first_);
  columns_.compare(row, first_, z.first(before), zstar.first(before));
  columns_.compare(row, 0, z.subspan(before, size_ - before), zstar.subspan(before, size_ - before));
}

}  // namespace choreo::similarity
