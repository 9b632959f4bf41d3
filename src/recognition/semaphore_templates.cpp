// SPDX-License-Identifier: Apache-2.0
#include "recognition/semaphore_templates.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace choreo::recognition {
namespace {

using body::kLeft;
using body::kRight;
using Eigen::Vector2d;

// A band of the picture, in units of the body's height, y up.
struct Band {
  Vector2d from, to;
  double width;
};

constexpr double kHandWidth = 0.042;
constexpr double kForearmBand = 0.044;  // of equal area with MATH's ellipse, nearly
constexpr double kUpperArmBand = 0.055;
constexpr double kFlagSide = 0.22;

std::vector<Band> bands_of(const body::Skeleton& s, body::Side side, ArmPart part) {
  const auto flat = [](const Eigen::Vector3d& p) -> Vector2d { return p.head<2>(); };
  const Vector2d shoulder = flat(s.shoulder[side]), elbow = flat(s.elbow[side]), wrist = flat(s.wrist[side]),
                 tip = flat(s.fingertip[side]);
  switch (part) {
    case ArmPart::kHand:
      return {{wrist, tip, kHandWidth}};
    case ArmPart::kForearm:
      return {{elbow, tip, kForearmBand}};
    case ArmPart::kHalfArm:
      return {{(shoulder + elbow) / 2, elbow, kUpperArmBand}, {elbow, tip, kForearmBand}};
    case ArmPart::kWholeArm:
      return {{shoulder, elbow, kUpperArmBand}, {elbow, tip, kForearmBand}};
    case ArmPart::kFlag: {
      const Vector2d along = (tip - wrist).normalized();
      return {{tip, tip + along * kFlagSide, kFlagSide}};
    }
  }
  return {};
}

// Moments of bands that do not overlap. Pixels, y down, a face 100 wide.
vision::Moments moments_of(std::span<const Band> bands, double scale) {
  double mass = 0;
  Vector2d mean = Vector2d::Zero();
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
  for (const auto& b : bands) {
    const Vector2d middle = (b.from + b.to) / 2;
    const Vector2d along = b.to - b.from;
    const double length = std::max(along.norm(), 1e-6);
    const Vector2d unit = along / length;
    const Vector2d across(-unit.y(), unit.x());
    // An arm that points at the viewer still shows its thickness.
    const double seen = std::max(length, b.width);
    const double area = seen * b.width;
    mass += area;
    mean += area * middle;
    second += area * (middle * middle.transpose() + unit * unit.transpose() * (seen * seen / 12) +
                      across * across.transpose() * (b.width * b.width / 12));
  }
  mean /= mass;
  second = second / mass - mean * mean.transpose();
  vision::Moments m;
  m.m00 = mass * scale * scale;
  m.centroid = {scale * mean.x(), -scale * mean.y()};
  m.mu20 = m.m00 * scale * scale * second(0, 0);
  m.mu11 = -m.m00 * scale * scale * second(0, 1);
  m.mu02 = m.m00 * scale * scale * second(1, 1);
  return m;
}

double distance(const Vector2d& p, const Band& b) {
  const Vector2d along = b.to - b.from;
  const double share = std::clamp((p - b.from).dot(along) / std::max(along.squaredNorm(), 1e-12), 0.0, 1.0);
  return (b.from + share * along - p).norm();
}

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

bool overlap(const Band& a, const Band& b) {
  const Vector2d u = a.to - a.from, v = b.to - b.from;
  const bool crossing = cross(u, b.from - a.from) * cross(u, b.to - a.from) < 0 &&
                        cross(v, a.from - b.from) * cross(v, a.to - b.from) < 0;
  const double nearest = std::min({distance(a.from, b), distance(a.to, b), distance(b.from, a), distance(b.to, a)});
  return crossing || nearest < (a.width + b.width) / 2;
}

// Whether an arm reaches over the body's middle to get to a position.
bool across(int position, body::Side side) { return position != 0 && (side == kLeft ? position < 4 : position > 4); }

body::SemaphoreSign swapped(const body::SemaphoreSign& sign) { return {sign.name, sign.right, sign.left}; }

}  // namespace

body::ParticleState template_state(const body::SemaphoreSign& sign, const TemplateVariant& variant,
                                   const body::ParticleBounds& bounds) {
  auto pose = body::semaphore_pose(variant.swapped ? swapped(sign) : sign);
  for (auto& arm : pose.arm) {
    arm.abduction += variant.spread;
    arm.twist = variant.bend < 0 ? -90 : 90;
    arm.elbow = std::abs(variant.bend);
  }
  const auto s = body::skeleton_of(pose);
  std::array<std::vector<Band>, 2> bands;
  for (const auto side : {kLeft, kRight}) bands[side] = bands_of(s, side, variant.part);
  bool joined = false;
  for (const auto& a : bands[kLeft]) {
    for (const auto& b : bands[kRight]) joined = joined || overlap(a, b);
  }
  // The face is a tenth high and ends below the crown with the hair.
  using namespace body::vitruvian;
  const Eigen::Vector3d face = s.skull - s.head_axes.col(1) * (kHeadHeight - kFaceWidth) / 2;
  const double scale = 100 * variant.size / kFaceWidth;
  const cv::Point2d centre(scale * face.x(), -scale * face.y());
  if (!joined) {
    return {moments_of(bands[kLeft], scale), moments_of(bands[kRight], scale), centre, 100, bounds};
  }
  auto all = bands[kLeft];
  all.insert(all.end(), bands[kRight].begin(), bands[kRight].end());
  const auto both = moments_of(all, scale);
  return {both, both, centre, 100, bounds};
}

UnitPsi unit_psi(const body::ParticleState& state) {
  UnitPsi psi = state.psi();
  double sum = 0;
  for (const double v : psi) sum += v * v;
  // Two of the parts have length 1 whatever the arms do.
  const double factor = 1 / std::sqrt(sum);
  for (double& v : psi) v *= factor;
  return psi;
}

std::vector<TemplateVariant> template_variants() {
  std::vector<TemplateVariant> all;
  for (const auto part : {ArmPart::kHand, ArmPart::kForearm, ArmPart::kHalfArm, ArmPart::kWholeArm, ArmPart::kFlag}) {
    for (const double bend : {0.0, 18.0, -18.0}) {
      for (const double size : {0.88, 1.0, 1.14}) all.push_back({part, false, bend, 0, size});
    }
  }
  return all;
}

SemaphoreTemplates::SemaphoreTemplates(const SemaphoreOptions& options, const body::ParticleBounds& bounds)
    : options_(options) {
  options_.validate();
  const auto signs = body::semaphore_signs();
  assert(signs.size() == kSemaphoreSigns);
  const auto add = [&](std::size_t sign, const body::ParticleState& state) {
    templates_.push_back({unit_psi(options_.mirrored ? mirrored(state) : state), sign, state.joined()});
  };
  for (std::size_t i = 0; i < signs.size(); ++i) {
    const bool rest = signs[i].left == 0 && signs[i].right == 0;
    for (auto variant : template_variants()) {
      add(i, template_state(signs[i], variant, bounds));
      // Hands that are folded or crossed before the body are at rest, too.
      if (rest) {
        for (const double spread : {-14.0, -24.0, 8.0}) {
          variant.spread = spread;
          add(i, template_state(signs[i], variant, bounds));
        }
        continue;
      }
      // The other way round where no more than one arm has to reach across.
      if (across(signs[i].right, kLeft) && across(signs[i].left, kRight)) continue;
      variant.swapped = true;
      add(i, template_state(signs[i], variant, bounds));
    }
  }
}

SignSimilarities SemaphoreTemplates::similarities(const UnitPsi& psi, bool joined) const {
  SignSimilarities best{};
  for (const auto& t : templates_) {
    if (t.joined != joined) continue;
    double z = 0;
    for (std::size_t k = 0; k < psi.size(); ++k) z += t.psi[k] * psi[k];
    best[t.sign] = std::max(best[t.sign], z);
  }
  for (double& z : best) z = std::min(z, 1.0);
  return best;
}

SignReading SemaphoreTemplates::read(const body::ParticleState& state) const {
  return read(similarities(unit_psi(state), state.joined()));
}

SignReading SemaphoreTemplates::read(const SignSimilarities& similarities) const {
  constexpr double kWidth = 0.2;  // rad
  const auto weight = [](double z) {
    const double angle = std::acos(z) / kWidth;
    return std::exp(-angle * angle / 2);
  };
  std::size_t best = 0;
  std::size_t next = 1;
  double sum = weight(options_.least_similarity);
  for (std::size_t i = 0; i < similarities.size(); ++i) {
    sum += weight(similarities[i]);
    if (i == 0) continue;
    if (similarities[i] > similarities[best]) {
      next = best;
      best = i;
    } else if (similarities[i] > similarities[next]) {
      next = i;
    }
  }
  const auto signs = body::semaphore_signs();
  SignReading reading;
  reading.similarity = similarities[best];
  reading.lead = similarities[best] - similarities[next];
  const double share = weight(similarities[best]) / sum;
  if (reading.similarity >= options_.least_similarity && reading.lead >= options_.margin) {
    reading.sign = signs[best].name;
    reading.runner_up = signs[next].name;
    reading.confidence = share;
  } else {
    reading.runner_up = signs[best].name;
    reading.confidence = 1 - share;
  }
  return reading;
}

}  // namespace choreo::recognition
