// SPDX-License-Identifier: Apache-2.0
#include "body/particle_calibration.hpp"

#include <algorithm>
#include <functional>

namespace choreo::body {
namespace {

double reached(std::vector<double> lengths, double vitruvian) {
  const auto rank = std::max<std::size_t>(2, lengths.size() / 50);
  const auto nth = lengths.begin() + std::ptrdiff_t(rank);
  std::nth_element(lengths.begin(), nth, lengths.end(), std::greater<>());
  return std::clamp(*nth, vitruvian / 2, 2 * vitruvian);
}

}  // namespace

void ParticleCalibration::add(const ParticleParts& parts) {
  alpha_.push_back(parts.alpha.norm());
  eta_.push_back(parts.eta.norm());
  c_.push_back(std::max(parts.c[0].norm(), parts.c[1].norm()));
}

ParticleBounds ParticleCalibration::bounds() const {
  const ParticleBounds vitruvian;
  if (frames() < kLeastFrames) return vitruvian;
  return {reached(alpha_, vitruvian.alpha_max), reached(c_, vitruvian.c_max), reached(eta_, vitruvian.eta_max)};
}

}  // namespace choreo::body
