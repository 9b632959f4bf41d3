// SPDX-License-Identifier: Apache-2.0
// Weights of which a file holds only those that are not zero.
#pragma once

#include <string_view>
#include <vector>

namespace choreo::vision {

/// One dimension of sparse weights.
struct SparseLevel {
  bool sparse = false;        ///< Else all of it is there.
  std::vector<int> segments;  ///< Where in `indices` the entries of each place above begin, and where the last end.
  std::vector<int> indices;   ///< Increasing within a segment.
};

/// All weights, in order of their indices, the last one fastest.
/// @param levels  one for each size of `shape`, outermost first (TACO's format, without blocks).
/// @throws Error (usage) where levels, shape and values do not fit together.
[[nodiscard]] std::vector<float> dense_weights(const std::vector<SparseLevel>& levels, const std::vector<int>& shape,
                                               const std::vector<float>& values);

/// "the network has no output". @throws Error (usage), always.
[[noreturn]] void refuse_network(std::string_view what);

}  // namespace choreo::vision
