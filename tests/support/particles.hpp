// SPDX-License-Identifier: Apache-2.0
// Particle states for tests: at random, and of mirror-symmetric bodies.
#pragma once

#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include "body/particle_state.hpp"

namespace choreo::test {

/// A vector of a length up to `longest` in any direction.
inline Eigen::Vector2d random_vector(std::mt19937& random, double longest) {
  const double angle = std::uniform_real_distribution<double>(0, 2 * std::numbers::pi)(random);
  const double length = std::uniform_real_distribution<double>(0, longest)(random);
  return {length * std::cos(angle), length * std::sin(angle)};
}

/// Arms anywhere, now and then beyond the bounds.
inline body::ParticleState random_particles(std::mt19937& random) {
  const body::ParticleBounds bounds;
  body::ParticleParts parts;
  parts.alpha = random_vector(random, 1.2 * bounds.alpha_max);
  parts.eta = random_vector(random, 1.2 * bounds.eta_max);
  for (auto& c : parts.c) c = random_vector(random, 1.2 * bounds.c_max);
  return {parts, bounds};
}

/// n states, every seventh a gap.
inline std::vector<std::optional<body::ParticleState>> random_particle_sequence(std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::optional<body::ParticleState>> states;
  for (std::size_t k = 0; k < n; ++k) {
    const auto state = random_particles(random);
    if (k % 7 == 5) {
      states.emplace_back();
    } else {
      states.emplace_back(state);
    }
  }
  return states;
}

/// The two arms mirror images of each other, the face between them.
inline body::ParticleState symmetric_particles(std::mt19937& random) {
  const body::ParticleBounds bounds;
  body::ParticleParts parts;
  parts.alpha.x() = random_vector(random, bounds.alpha_max).x();
  parts.eta.y() = random_vector(random, bounds.eta_max).y();
  parts.c[0] = random_vector(random, bounds.c_max);
  parts.c[1] = {parts.c[0].x(), -parts.c[0].y()};
  return {parts, bounds};
}

}  // namespace choreo::test
