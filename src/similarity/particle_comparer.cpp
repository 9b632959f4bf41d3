// SPDX-License-Identifier: Apache-2.0
#include "similarity/particle_comparer.hpp"

#include <cassert>

namespace choreo::similarity {

ParticleComparer::ParticleComparer(std::span<const std::optional<body::ParticleState>> states)
    : columns_(states.size()) {
  for (std::size_t k = 0; k < states.size(); ++k) {
    columns_.put(k, ParticleColumns::row_of(states[k] ? &*states[k] : nullptr));
  }
}

void ParticleComparer::compare(Range rows, Range cols, MatrixView<float> z, MatrixView<float> zstar) const {
  assert(z.rows() == rows.size() && z.cols() == cols.size());
  assert(zstar.rows() == rows.size() && zstar.cols() == cols.size());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    columns_.compare(columns_.at(rows.begin + k), cols.begin, z.row(k), zstar.row(k));
  }
}

}  // namespace choreo::similarity
