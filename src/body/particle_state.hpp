// SPDX-License-Identifier: Apache-2.0
// The body as two particles beside a face: the state of bare forearms, gloves or flags.
#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

#include "body/body_state.hpp"
#include "vision/arms.hpp"
#include "vision/face.hpp"

namespace choreo::body {

/// How long the lengths of a state can grow, in face widths: what the lifts take for their full circle. The defaults
/// are those of the Vitruvian figure with bare forearms (docs/mathematics.md, particles).
struct ParticleBounds {
  static constexpr double kLeast = 0.01, kMost = 100;  ///< The range of each.

  double alpha_max = 3.75;  ///< Half the distance between the arms.
  double c_max = 0.1875;    ///< Length of the covariance's two components, face widths squared.
  double eta_max = 4.8;     ///< From the face to the middle between the arms.

  /// @throws Error (usage) where a bound is not from kLeast to kMost.
  void validate() const;
};

/// What a state is made of. Vectors in face widths with x to the picture's right and y UP.
struct ParticleParts {
  Eigen::Vector2d alpha = Eigen::Vector2d::Zero();  ///< (r1 - r2) / 2.
  Eigen::Vector2d eta = Eigen::Vector2d::Zero();    ///< (r1 + r2) / 2 - r_face.
  std::array<Eigen::Vector2d, 2> c{Eigen::Vector2d::Zero(),
                                   Eigen::Vector2d::Zero()};  ///< (cov_xx - cov_yy, 2 cov_xy) / 2 of each arm.
  Eigen::Vector3d nu = Eigen::Vector3d::UnitX();              ///< lift(alpha, alpha_max).
  Eigen::Vector3d u = Eigen::Vector3d::UnitX();               ///< lift(eta, eta_max).
  std::array<Eigen::Vector3d, 2> zeta{Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitX()};  ///< lift(c_k, c_max).
};

/// lift(v, max) = (sqrt(1 - s^2), s v / |v|), s = min(1, |v| / max): a vector of length 1; (1, 0, 0) for v = 0.
[[nodiscard]] Eigen::Vector3d lift(const Eigen::Vector2d& v, double max);

inline constexpr int kParticleValues = 15;

/// What mirroring does to each value of Psi.
inline constexpr std::array<int, kParticleValues> kParticleMirrorSigns{1,  -1, 1, 1,  1, -1, 1, 1,
                                                                       -1, -1, 1, -1, 1, 1,  -1};

/// Psi = [u, (cos beta, sin beta cos 2 phi, sin beta sin 2 phi), zeta1 + zeta2, (zeta1 - zeta2) (x) sin beta (cos phi,
/// sin phi)], the outer product row by row. Swapping the arms leaves it unchanged, to the last bit.
/// @source Performance Physics, 5.9, corrected (docs/mathematics.md).
class ParticleState {
 public:
  /// @param first, second    the arms, m00 > 0; the same twice where they are joined (alpha = 0, zeta1 = zeta2).
  /// @param face_centre      px, of the same picture.
  /// @param face_width       px, > 0 (asserted, as are finite numbers).
  ParticleState(const vision::Moments& first, const vision::Moments& second, cv::Point2d face_centre, double face_width,
                const ParticleBounds& bounds = {});

  /// From lengths and covariances that are known already: alpha, eta and c of `parts`, finite (asserted), count; the
  /// lifts are computed.
  ParticleState(ParticleParts parts, const ParticleBounds& bounds);

  [[nodiscard]] const std::array<double, kParticleValues>& psi() const { return psi_; }
  [[nodiscard]] const ParticleParts& parts() const {
    return parts_;
  }                                                      ///< Of a mirrored state: mirrored; arm k stays arm k.
  [[nodiscard]] bool joined() const { return joined_; }  ///< Both arms are one region.

  friend ParticleState mirrored(const ParticleState& a);

 private:
  ParticleState() = default;
  std::array<double, kParticleValues> psi_{};
  ParticleParts parts_;
  bool joined_ = false;
};

/// The state of what was found; joined arms are one region twice. Nothing without a face or without both arms.
[[nodiscard]] std::optional<ParticleState> particle_state_of(const vision::Arms& arms,
                                                             const std::optional<vision::TrackedFace>& face,
                                                             const ParticleBounds& bounds = {});

/// The state of the mirror image: x to -x.
[[nodiscard]] ParticleState mirrored(const ParticleState& a);

/// Z(a, b) = max(0, cosine of the angle between the two Psi); exactly 1 for a state with itself.
[[nodiscard]] double similarity(const ParticleState& a, const ParticleState& b);

/// Z*(a, b) = Z(a*, b).
[[nodiscard]] double mirror_similarity(const ParticleState& a, const ParticleState& b);

static_assert(BodyState<ParticleState>);

}  // namespace choreo::body
