// SPDX-License-Identifier: Apache-2.0
#include "recognition/semaphore_templates.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <utility>

#include "vision/face_region.hpp"

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

constexpr double kForearmBand = 0.044;
constexpr double kUpperArmBand = 0.055;
constexpr double kFlagSide = 0.2;

std::vector<Band> bands_of(const body::Skeleton& s, body::Side side, const TemplateVariant& variant) {
  using body::vitruvian::kForearm, body::vitruvian::kUpperArm;
  const auto flat = [](const Eigen::Vector3d& p) -> Vector2d { return p.head<2>(); };
  const Vector2d shoulder = flat(s.shoulder[side]), elbow = flat(s.elbow[side]), tip = flat(s.fingertip[side]);
  if (variant.flag) {
    const Vector2d along = (tip - elbow).normalized();
    const Vector2d from = tip + along * (*variant.flag - kFlagSide / 2);
    return {{from, from + along * kFlagSide, kFlagSide}};
  }
  const double covered = variant.sleeve * (kUpperArm + kForearm);
  if (covered >= kUpperArm) return {{elbow + (tip - elbow) * (covered - kUpperArm) / kForearm, tip, kForearmBand}};
  return {{shoulder + (elbow - shoulder) * covered / kUpperArm, elbow, kUpperArmBand}, {elbow, tip, kForearmBand}};
}

// What the face's region leaves of bands: there skin cannot be told from skin, and nothing is taken for an arm.
std::vector<Band> beside_face(const std::vector<Band>& bands, const Vector2d& face, double face_width) {
  constexpr int kSlices = 60;
  std::vector<Band> left;
  for (const auto& b : bands) {
    const auto at = [&](double share) -> Vector2d { return b.from + share * (b.to - b.from); };
    int begin = -1;  // of a stretch that is seen
    for (int k = 0; k <= kSlices; ++k) {
      bool seen = false;
      if (k < kSlices) {
        const Vector2d p = (at((k + 0.5) / kSlices) - face) / face_width;
        seen = !vision::in_face_region(p.x(), -p.y());
      }
      if (seen && begin < 0) begin = k;
      if (!seen && begin >= 0) left.push_back({at(double(begin) / kSlices), at(double(k) / kSlices), b.width});
      if (!seen) begin = -1;
    }
  }
  return left;
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

// How large the bounds say that the body is, against the Vitruvian figure. Flags reach farther than arms, if they were
// held when the bounds were found.
double body_size(const body::ParticleBounds& bounds, const std::optional<double>& flag) {
  const double arms = bounds.alpha_max / body::ParticleBounds{}.alpha_max;
  if (!flag) return arms;
  using namespace body::vitruvian;
  return std::max(1.0, bounds.alpha_max * kFaceWidth / (kShoulderHalf + kUpperArm + kForearm + *flag));
}

// Both arms hang, or both point to one side.
bool meeting(const body::SemaphoreSign& sign) {
  if (sign.left == 0 || sign.right == 0) return sign.left == sign.right;
  return (sign.left < 4 && sign.right < 4) || (sign.left > 4 && sign.right > 4);
}

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
  // The face is a tenth high and ends below the crown with the hair.
  using namespace body::vitruvian;
  const Eigen::Vector3d face = s.skull - s.head_axes.col(1) * (kHeadHeight - kFaceWidth) / 2;
  for (const auto side : {kLeft, kRight}) {
    bands[side] = bands_of(s, side, variant);
    if (!variant.face_hides) continue;
    auto left = beside_face(bands[side], face.head<2>(), kFaceWidth / variant.size);
    if (!left.empty()) bands[side] = std::move(left);
  }
  bool joined = false;
  for (const auto& a : bands[kLeft]) {
    for (const auto& b : bands[kRight]) joined = joined || overlap(a, b);
  }
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

bool arms_fit(const body::ParticleParts& seen, const body::ParticleParts& sought) {
  constexpr double kLeastScale = 0.8, kMostScale = 1.4;
  constexpr double kFarthest = 0.9;  // face widths
  constexpr double kLongish = 0.04;  // face widths squared: a c from which an arm has an axis
  const double kCosine = std::cos(2 * 20 * std::numbers::pi / 180);
  // Which arm is the first is nobody's choice.
  const bool same = seen.alpha.dot(sought.alpha) >= 0;
  const Vector2d alpha = same ? sought.alpha : Vector2d(-sought.alpha);
  const std::array<Vector2d, 2> a = {seen.eta + seen.alpha, seen.eta - seen.alpha};
  const std::array<Vector2d, 2> b = {sought.eta + alpha, sought.eta - alpha};
  const double scale = std::clamp((a[0].dot(b[0]) + a[1].dot(b[1])) / (b[0].squaredNorm() + b[1].squaredNorm()),
                                  kLeastScale, kMostScale);
  for (std::size_t k = 0; k < 2; ++k) {
    if ((a[k] - scale * b[k]).norm() > kFarthest * scale) return false;
    const auto& c = seen.c[k];
    const auto& d = sought.c[same ? k : 1 - k];
    const double longish = std::min(c.norm(), d.norm());
    // c turns twice as fast as the arm.
    if (longish >= kLongish && c.dot(d) < kCosine * c.norm() * d.norm()) return false;
  }
  return true;
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
  const auto add = [&](double sleeve, std::optional<double> flag) {
    for (const double bend : {0.0, 15.0, -15.0}) {
      for (const double size : {0.86, 1.0, 1.16, 1.34}) all.push_back({sleeve, flag, false, bend, 0, size});
    }
  };
  // Below the elbow the covariance changes most.
  for (const double sleeve : {0.0, 0.18, 1.0 / 3, 0.48, 0.54, 0.61, 0.75}) add(sleeve, {});
  for (const double flag : {0.02, 0.11}) add(0, flag);
  return all;
}

SemaphoreTemplates::SemaphoreTemplates(const SemaphoreOptions& options, const body::ParticleBounds& bounds)
    : options_(options) {
  options_.validate();
  bounds.validate();
  const auto signs = body::semaphore_signs();
  assert(signs.size() == kSemaphoreSigns);
  const auto add = [&](std::size_t sign, const body::ParticleState& state) {
    // Joined arms say little: only where they are expected to meet is that a sign, else it is arms joined by a shirt.
    if (state.joined() && !meeting(signs[sign])) return;
    const auto shown = options_.mirrored ? mirrored(state) : state;
    templates_.push_back({unit_psi(shown), shown, sign});
  };
  const auto add_shown = [&](std::size_t i, TemplateVariant variant) {
    const auto whole = template_state(signs[i], variant, bounds);
    add(i, whole);
    variant.face_hides = true;
    const auto cut = template_state(signs[i], variant, bounds);
    if (cut.psi() != whole.psi()) add(i, cut);
  };
  for (std::size_t i = 0; i < signs.size(); ++i) {
    const bool rest = signs[i].left == 0 && signs[i].right == 0;
    for (auto variant : template_variants()) {
      variant.size *= body_size(bounds, variant.flag);
      add_shown(i, variant);
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
      add_shown(i, variant);
    }
  }
}

SignMatch SemaphoreTemplates::match(const UnitPsi& psi, const body::ParticleState& state) const {
  constexpr double kAlike = 0.005;
  SignMatch match;
  const Template* nearest = nullptr;
  double most = 0;
  for (const auto& t : templates_) {
    if (t.state.joined() != state.joined()) continue;
    double z = 0;
    for (std::size_t k = 0; k < psi.size(); ++k) z += t.psi[k] * psi[k];
    auto& best = match.similarity[t.sign];
    best = std::max(best, std::min(z, 1.0));
    if (z > most) {
      most = z;
      nearest = &t;
    }
  }
  if (nearest == nullptr) return match;
  // Far beyond the bounds an arm's template and a flag's are alike in Psi, and only one of them is as far away.
  const auto as_near = [&](const Template& t) {
    if (t.sign != nearest->sign || t.state.joined() != state.joined()) return false;
    double z = 0;
    for (std::size_t k = 0; k < psi.size(); ++k) z += t.psi[k] * psi[k];
    return z >= most - kAlike && arms_fit(state.parts(), t.state.parts());
  };
  match.fits =
      arms_fit(state.parts(), nearest->state.parts()) || std::any_of(templates_.begin(), templates_.end(), as_near);
  return match;
}

SignReading SemaphoreTemplates::read(const std::optional<body::ParticleState>& state) const {
  if (!state) {
    SignReading none;
    none.confidence = 1;
    return none;
  }
  return read(match(unit_psi(*state), *state));
}

SignReading SemaphoreTemplates::read(const SignMatch& match) const {
  const auto& similarities = match.similarity;
  constexpr double kWidth = 0.1;  // rad
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
  const double share = weight(similarities[best]) / sum;
  const bool leads = similarities[best] - similarities[next] >= options_.margin;
  if (similarities[best] >= options_.least_similarity && leads && match.fits) {
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
