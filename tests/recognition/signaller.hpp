// SPDX-License-Identifier: Apache-2.0
// A signaller as particle states: the figure's arms seen with all that differs between people, clothes and cameras.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "body/figure.hpp"
#include "body/particle_state.hpp"
#include "body/semaphore_signs.hpp"

namespace choreo::test {

/// Who signals and how they are seen. Made apart from the templates: arms are sums of discs along the limbs.
struct Signaller {
  double sleeve = 1.0 / 3;  ///< How much of the arm is covered, from the shoulder; a third is to the elbow.
  double arm = 1;           ///< Factor on the arms' length,
  double body = 1;          ///< and on everything against the face.
  double thickness = 1;     ///< Of the arms.
  double face = 1;          ///< Found face width over the true one.
  Eigen::Vector2d face_shift = Eigen::Vector2d::Zero();  ///< Of the found face, in face widths.
  double joint_jitter = 0;                               ///< Degrees rms of every sign's joints.
  double bend = 0;                                       ///< Degrees of the elbows.
  double forward = 0;                                    ///< Degrees by which arms are held forward.
  double centroid_noise = 0;                             ///< Face widths rms.
  double covariance_noise = 0;                           ///< Share rms.
  bool swapped = false;                                  ///< The other arm reaches across.
};

inline double uniform(std::mt19937_64& chance, double least, double most) {
  return least + (most - least) * (static_cast<double>(chance() >> 11) * 0x1p-53);
}
inline double normal(std::mt19937_64& chance) {
  const double u = 1 - uniform(chance, 0, 1);
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * uniform(chance, 0, 1));
}

/// Anybody: sleeves from wrist to shoulder, arms of any usual length, a face up to 15 % wrong.
inline Signaller anybody(std::mt19937_64& chance, double severity = 1) {
  Signaller s;
  s.sleeve = uniform(chance, 0, 0.68);
  s.arm = 1 + severity * uniform(chance, -0.06, 0.06);
  s.thickness = uniform(chance, 0.8, 1.25);
  s.face = 1 + severity * uniform(chance, -0.15, 0.15);
  s.face_shift = severity * Eigen::Vector2d(uniform(chance, -0.15, 0.15), uniform(chance, -0.15, 0.15));
  s.joint_jitter = 4 * severity;
  s.bend = severity * uniform(chance, 0, 14);
  s.forward = severity * uniform(chance, 0, 15);
  s.centroid_noise = 0.03 * severity;
  s.covariance_noise = 0.05 * severity;
  return s;
}

/// The figure's arms as two blobs, or as one where they touch.
inline body::ParticleState seen(const body::Pose& pose, const Signaller& who, std::mt19937_64& chance,
                                const body::ParticleBounds& bounds = {}) {
  const auto s = body::skeleton_of(pose);
  struct Disc {
    Eigen::Vector2d at;
    double radius;
  };
  std::array<std::vector<Disc>, 2> arms;
  for (const auto side : {body::kLeft, body::kRight}) {
    constexpr int kDiscs = 60;
    const double length = body::vitruvian::kUpperArm + body::vitruvian::kForearm;
    for (int i = 0; i <= kDiscs; ++i) {
      const double along = double(i) / kDiscs;
      if (along < who.sleeve) continue;
      const double h = along * length;
      const bool upper = h < body::vitruvian::kUpperArm;
      const Eigen::Vector3d at =
          upper ? s.shoulder[side] + (s.elbow[side] - s.shoulder[side]) * h / body::vitruvian::kUpperArm
                : s.elbow[side] + (s.fingertip[side] - s.elbow[side]) * (h - body::vitruvian::kUpperArm) /
                                      body::vitruvian::kForearm;
      const Eigen::Vector3d stretched = s.shoulder[side] + (at - s.shoulder[side]) * who.arm;
      const double taper = upper ? 0.027 : 0.024 - 0.008 * (h - 0.125) / 0.25;
      arms[side].push_back({stretched.head<2>(), taper * who.thickness});
    }
  }
  const double unit = 10 * who.body / who.face;
  const auto moments = [&](const std::vector<const std::vector<Disc>*>& parts) {
    double mass = 0;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (const auto* p : parts) {
      for (const auto& d : *p) {
        mass += d.radius;
        mean += d.radius * d.at;
      }
    }
    mean /= mass;
    Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
    for (const auto* p : parts) {
      for (const auto& d : *p) {
        second += d.radius *
                  ((d.at - mean) * (d.at - mean).transpose() + Eigen::Matrix2d::Identity() * d.radius * d.radius / 3);
      }
    }
    second *= unit * unit / mass;
    const double a = 1 + who.covariance_noise * normal(chance);
    const double b = who.covariance_noise * normal(chance);
    const double c = 1 + who.covariance_noise * normal(chance);
    Eigen::Matrix2d noise;
    noise << a, b, b, c;
    second = noise * second * noise.transpose();
    mean = mean * unit + who.centroid_noise * Eigen::Vector2d(normal(chance), normal(chance));
    vision::Moments m;
    m.m00 = 1;
    m.centroid = {mean.x(), -mean.y()};
    m.mu20 = second(0, 0);
    m.mu11 = -second(0, 1);
    m.mu02 = second(1, 1);
    return m;
  };
  double gap = 1e9;
  for (const auto& a : arms[0]) {
    for (const auto& b : arms[1]) gap = std::min(gap, (a.at - b.at).norm() - a.radius - b.radius);
  }
  const Eigen::Vector2d face = s.skull.head<2>() * unit - Eigen::Vector2d(0, 0.125 * unit / 10) + who.face_shift;
  const cv::Point2d centre(face.x(), -face.y());
  if (gap < 0) {
    const auto both = moments({&arms[0], &arms[1]});
    return {both, both, centre, 1, bounds};
  }
  const auto left = moments({&arms[0]});
  const auto right = moments({&arms[1]});
  return {left, right, centre, 1, bounds};
}

/// The figure showing a sign in this signaller's way.
inline body::Pose signalled(const body::SemaphoreSign& sign, const Signaller& who, std::mt19937_64& chance) {
  auto shown = sign;
  if (who.swapped) std::swap(shown.left, shown.right);
  auto pose = body::semaphore_pose(shown);
  for (auto& arm : pose.arm) {
    arm.abduction += who.joint_jitter * normal(chance);
    arm.flexion += who.forward + who.joint_jitter * normal(chance);
    arm.twist = uniform(chance, -90, 90);
    arm.elbow = std::abs(who.bend + who.joint_jitter * normal(chance));
  }
  pose.trunk_side = who.joint_jitter / 3 * normal(chance);
  return pose;
}

}  // namespace choreo::test
