// SPDX-License-Identifier: Apache-2.0
// The contract of a body state: what every representation of a body must offer.
#pragma once

#include <concepts>

namespace choreo::body {

// Found by argument; these keep the namespace choreo::similarity from hiding the functions, whatever is included first.
void mirrored() = delete;
void similarity() = delete;
void mirror_similarity() = delete;

/// A body state Psi with its mirror image Psi* and the two similarities Z and Z*, both in [0, 1].
///
/// Z(a,a) = 1, Z(a,b) = Z(b,a), Z*(a,b) = Z*(b,a), mirroring twice is the identity, and Z*(a,a) = 1 for a
/// mirror-symmetric body. Everything after body/ is written against this and works with every representation.
/// @source Performance Physics, 3.1.
template <typename State>
concept BodyState = requires(const State& a, const State& b) {
  { mirrored(a) } -> std::same_as<State>;
  { similarity(a, b) } -> std::same_as<double>;
  { mirror_similarity(a, b) } -> std::same_as<double>;
};

}  // namespace choreo::body
