// SPDX-License-Identifier: Apache-2.0
// The matrices Z and Z* of a whole recording.
#pragma once

#include <functional>
#include <stop_token>

#include "core/matrix_view.hpp"
#include "similarity/comparer.hpp"

namespace choreo::similarity {

/// Takes the rows of a band, each against all states from the first to the band's last.
/// @param z, zstar  rows.size() x rows.end; row i holds Z(rows.begin + i, 0 ... rows.end - 1). Only valid during the
/// call.
using BandSink = std::function<void(Range rows, MatrixView<const float> z, MatrixView<const float> zstar)>;

/// Gives Z and Z* of all pairs band by band, in order of time; each pair is compared once. What lies right of a band
/// is known by symmetry once the later bands are. Memory is that of one band, however many states there are.
///
/// Uses the cores of the calling TBB arena; the result does not depend on how many. The sink is called in the calling
/// thread.
/// @param progress  called with the share done, 0 to 1, after each band; may be empty.
/// @return false where `stop` was requested before the end; no band is given incomplete.
/// @cost O(N^2 / 2) comparisons.
bool pairs_by_bands(const Comparer& states, const BandSink& sink, std::stop_token stop = {},
                    const std::function<void(double)>& progress = {});

/// Fills the N x N matrices Z and Z*; each pair is computed once and written to both its places.
///
/// Uses the cores of the calling TBB arena; the result does not depend on how many.
/// @param z, zstar  N x N, N = states.size().
/// @param progress  called with the share done, 0 to 1, now and then; may be empty.
/// @return false where `stop` was requested before the end; the matrices are then incomplete.
/// @cost O(N^2 / 2) comparisons.
bool all_pairs(const Comparer& states, MatrixView<float> z, MatrixView<float> zstar, std::stop_token stop = {},
               const std::function<void(double)>& progress = {});

}  // namespace choreo::similarity
