// SPDX-License-Identifier: Apache-2.0
#include "body/particle_state.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "core/error.hpp"

namespace choreo::body {
namespace {

void check(double value, std::string_view name) {
  if (value >= ParticleBounds::kLeast && value <= ParticleBounds::kMost) return;
  throw usage_error(fmt::format("'{}' is not from {} to {}", value, ParticleBounds::kLeast, ParticleBounds::kMost),
                    fmt::format("particles.{}", name));
}

// c of one arm in face widths squared, y up.
Eigen::Vector2d covariance_components(const vision::Moments& arm, double face_width) {
  const double unit = arm.m00 * face_width * face_width;
  return {(arm.mu20 - arm.mu02) / 2 / unit, -arm.mu11 / unit};
}

ParticleParts parts_of(const vision::Moments& first, const vision::Moments& second, cv::Point2d face_centre,
                       double face_width) {
  assert(first.m00 > 0 && second.m00 > 0 && face_width > 0);
  const Eigen::Vector2d r1(first.centroid.x, -first.centroid.y);
  const Eigen::Vector2d r2(second.centroid.x, -second.centroid.y);
  const Eigen::Vector2d face(face_centre.x, -face_centre.y);
  ParticleParts parts;
  parts.alpha = (r1 - r2) / 2 / face_width;
  parts.eta = ((r1 + r2) / 2 - face) / face_width;
  parts.c = {covariance_components(first, face_width), covariance_components(second, face_width)};
  return parts;
}

// <a, b> over the values that mirroring keeps and over those that it turns: Z adds the two, Z* subtracts them.
struct Products {
  double kept = 0;
  double turned = 0;
};

Products products(const ParticleState& a, const ParticleState& b) {
  Products sum;
  for (std::size_t k = 0; k < a.psi().size(); ++k) {
    (kParticleMirrorSigns[k] > 0 ? sum.kept : sum.turned) += a.psi()[k] * b.psi()[k];
  }
  return sum;
}

// The root of a square is exact, so a state is exactly like itself.
double similarity_of(double product, const ParticleState& a, const ParticleState& b) {
  const auto own = products(a, a);
  const auto other = products(b, b);
  const double norm = std::sqrt((own.kept + own.turned) * (other.kept + other.turned));
  return std::clamp(product / norm, 0.0, 1.0);
}

}  // namespace

void ParticleBounds::validate() const {
  check(alpha_max, "alpha_max");
  check(c_max, "c_max");
  check(eta_max, "eta_max");
}

Eigen::Vector3d lift(const Eigen::Vector2d& v, double max) {
  assert(max > 0);
  const double length = std::hypot(v.x(), v.y());
  if (length == 0) return Eigen::Vector3d::UnitX();
  const double s = std::min(1.0, length / max);
  return {std::sqrt((1 - s) * (1 + s)), s * (v.x() / length), s * (v.y() / length)};
}

ParticleState::ParticleState(const vision::Moments& first, const vision::Moments& second, cv::Point2d face_centre,
                             double face_width, const ParticleBounds& bounds)
    : ParticleState(parts_of(first, second, face_centre, face_width), bounds) {}

ParticleState::ParticleState(ParticleParts parts, const ParticleBounds& bounds) : parts_(std::move(parts)) {
  auto& p = parts_;
  assert(p.alpha.allFinite() && p.eta.allFinite() && p.c[0].allFinite() && p.c[1].allFinite());
  p.nu = lift(p.alpha, bounds.alpha_max);
  p.u = lift(p.eta, bounds.eta_max);
  for (std::size_t k = 0; k < 2; ++k) p.zeta[k] = lift(p.c[k], bounds.c_max);
  joined_ = p.alpha.isZero(0) && p.c[0] == p.c[1];

  // Every value is even in (alpha, zeta1 - zeta2), so that swapping the arms changes no bit.
  const double sin_beta = std::hypot(p.nu.y(), p.nu.z());
  const double cos_phi = sin_beta == 0 ? 1 : p.nu.y() / sin_beta;
  const double sin_phi = sin_beta == 0 ? 0 : p.nu.z() / sin_beta;
  const Eigen::Vector3d sum = p.zeta[0] + p.zeta[1];
  const Eigen::Vector3d difference = p.zeta[0] - p.zeta[1];
  psi_ = {p.u.x(),
          p.u.y(),
          p.u.z(),
          p.nu.x(),
          sin_beta * (cos_phi - sin_phi) * (cos_phi + sin_phi),
          sin_beta * 2 * sin_phi * cos_phi,
          sum.x(),
          sum.y(),
          sum.z()};
  for (int k = 0; k < 3; ++k) {
    psi_[std::size_t(9 + 2 * k)] = difference[k] * p.nu.y();
    psi_[std::size_t(10 + 2 * k)] = difference[k] * p.nu.z();
  }
}

std::optional<ParticleState> particle_state_of(const vision::Arms& arms, const std::optional<vision::TrackedFace>& face,
                                               const ParticleBounds& bounds) {
  const bool joined = arms.found == vision::ArmCase::kJoined;
  if (!face || (!joined && arms.found != vision::ArmCase::kTwoArms)) return std::nullopt;
  return ParticleState(arms.blob[0].moments, arms.blob[joined ? 0 : 1].moments, face->centre, face->width, bounds);
}

ParticleState mirrored(const ParticleState& a) {
  ParticleState m = a;
  for (std::size_t k = 0; k < m.psi_.size(); ++k) m.psi_[k] *= kParticleMirrorSigns[k];
  auto& p = m.parts_;
  p.alpha.x() *= -1;
  p.eta.x() *= -1;
  p.nu.y() *= -1;
  p.u.y() *= -1;
  for (auto& c : p.c) c.y() *= -1;
  for (auto& zeta : p.zeta) zeta.z() *= -1;
  return m;
}

double similarity(const ParticleState& a, const ParticleState& b) {
  const auto sum = products(a, b);
  return similarity_of(sum.kept + sum.turned, a, b);
}

double mirror_similarity(const ParticleState& a, const ParticleState& b) {
  const auto sum = products(a, b);
  return similarity_of(sum.kept - sum.turned, a, b);
}

}  // namespace choreo::body
