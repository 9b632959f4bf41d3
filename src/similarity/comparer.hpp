// SPDX-License-Identifier: Apache-2.0
// The contract between a representation of the body and everything that compares states.
#pragma once

#include <cstddef>

#include "core/matrix_view.hpp"

namespace choreo::similarity {

/// Half-open range of states, in order of time.
struct Range {
  std::size_t begin = 0;
  std::size_t end = 0;
  [[nodiscard]] std::size_t size() const { return end - begin; }
};

/// A sequence of N states that can be compared by blocks.
///
/// One representation (masks, particles, kinematic chain) is one implementation; matrices, plots, motifs and
/// recognition know only this.
/// @thread thread-safe: `compare` is const and called from many threads at once.
class Comparer {
 public:
  virtual ~Comparer() = default;

  /// How many states, N.
  [[nodiscard]] virtual std::size_t size() const = 0;

  /// Fills z(i, j) = Z(rows.begin + i, cols.begin + j), and zstar likewise with Z*.
  /// @param z, zstar  rows.size() x cols.size(). NaN where either state is a gap (a frame without a body).
  virtual void compare(Range rows, Range cols, MatrixView<float> z, MatrixView<float> zstar) const = 0;
};

}  // namespace choreo::similarity
