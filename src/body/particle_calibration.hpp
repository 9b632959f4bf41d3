// SPDX-License-Identifier: Apache-2.0
// How far this performer's arms reach, from a stretch of them.
#pragma once

#include <cstddef>
#include <vector>

#include "body/particle_state.hpp"

namespace choreo::body {

/// Collects states while the performer stretches the arms to all sides, and gives the bounds that they reached.
///
/// A bound is the largest length that was reached in more than 2 % of the frames, and in at least three: a wild frame
/// or two are no stretch. It is kept between half and twice the Vitruvian one, and c, which grows with an arm's length
/// squared, between a quarter and four times: who stood still has not stretched.
/// @source Performance Physics, 5.8.
class ParticleCalibration {
 public:
  /// @param parts  alpha, eta and c count; of a frame with two arms.
  void add(const ParticleParts& parts);

  [[nodiscard]] std::size_t frames() const { return alpha_.size(); }

  /// What was reached, as it is; the defaults while there are fewer than kLeastFrames.
  /// @cost O(frames).
  [[nodiscard]] ParticleBounds reached() const;

  /// The same, kept near the defaults.
  [[nodiscard]] ParticleBounds bounds() const;

  static constexpr std::size_t kLeastFrames = 15;  ///< Half a second.

 private:
  std::vector<double> alpha_;
  std::vector<double> eta_;
  std::vector<double> c_;  // The longer of the two.
};

}  // namespace choreo::body
