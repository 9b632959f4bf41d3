// SPDX-License-Identifier: Apache-2.0
// The matrices Z and Z* of a whole recording.
#pragma once

#include <functional>
#include <stop_token>

#include "core/matrix_view.hpp"
#include "similarity/comparer.hpp"

namespace choreo::similarity {

/// Fills the N x N matrices Z and Z*; each pair is computed once and written to both its places.
///
/// Uses the cores of the calling TBB arena; the result does not depend on how many.
/// @param z, zstar  N x N, N = states.size().
/// @param progress  called with the share done, 0 to 1, from any thread, now and then; may be empty.
/// @return false where `stop` was requested before the end; the matrices are then incomplete.
/// @cost O(N^2 / 2) comparisons.
bool all_pairs(const Comparer& states, MatrixView<float> z, MatrixView<float> zstar, std::stop_token stop = {},
               const std::function<void(double)>& progress = {});

}  // namespace choreo::similarity
