// SPDX-License-Identifier: Apache-2.0
#include "body/particle_calibration.hpp"

#include <algorithm>
#include <functional>

namespace choreo::body {
namespace {

double held(std::vector<double> lengths) {
  const auto rank = std::max<std::size_t>(2, lengths.size() / 50);
  const auto nth = lengths.begin() + std::ptrdiff_t(rank);
  std::nth_element(lengths.begin(), nth, lengths.end(), std::greater<>());
  return *nth;
}

double kept(double reached, double vitruvian, double factor) {
  return std::clamp(reached, vitruvian / factor, factor * vitruvian);
}

}  // namespace

void ParticleCalibration::add(const ParticleParts& parts) {
  alpha_.push_back(parts.alpha.norm());
  eta_.push_back(parts.eta.norm());
  c_.push_back(std::max(parts.c[0].norm(), parts.c[1].norm()));
}

ParticleBounds ParticleCalibration::reached() const {
  if (frames() < kLeastFrames) return {};
  return {held(alpha_), held(c_), held(eta_)};
}

ParticleBounds ParticleCalibration::bounds() const {
  const ParticleBounds vitruvian;
  const auto far = reached();
  return {kept(far.alpha_max, vitruvian.alpha_max, 2), kept(far.c_max, vitruvian.c_max, 4),
          kept(far.eta_max, vitruvian.eta_max, 2)};
}

}  // namespace choreo::body
