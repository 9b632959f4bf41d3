// SPDX-License-Identifier: Apache-2.0
#include "devices/synthetic/mannequin.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "devices/synthetic/head.hpp"

namespace choreo::devices::synthetic {
namespace {

using body::kLeft;
using body::kRight;
using Eigen::Vector3d;

// Half thicknesses in units of the body's height along each part, from the trunk outwards.
const Profile kForearm = {{0, 0.0215},    {0.18, 0.0245}, {0.40, 0.0205}, {0.58, 0.0155}, {0.66, 0.0170},
                          {0.76, 0.0225}, {0.86, 0.0210}, {0.94, 0.0165}, {1, 0.0095}};
const Profile kCrease = {{0, 0.0004}, {1, 0.0011}};
const Profile kThumb = {{0, 0.0085}, {0.5, 0.0080}, {1, 0.0060}};
const Profile kSleeve = {{0, 0.0310}, {0.45, 0.0305}, {1, 0.0285}};
const Profile kLongSleeve = {{0, 0.0285}, {0.3, 0.0275}, {0.8, 0.0215}, {1, 0.0210}};
const Profile kUpperArm = {{0, 0.0270}, {0.3, 0.0262}, {0.55, 0.0255}, {0.85, 0.0218}, {1, 0.0215}};
const Profile kShoulder = {{0, 0.0140}, {0.5, 0.0240}, {0.8, 0.0295}, {1, 0.0300}};
const Profile kThigh = {{0, 0.0500}, {0.25, 0.0485}, {0.7, 0.0385}, {1, 0.0350}};
const Profile kShank = {{0, 0.0350}, {0.3, 0.0355}, {0.7, 0.0285}, {1, 0.0270}};
const Profile kShoe = {{0, 0.0200}, {0.45, 0.0225}, {0.8, 0.0230}, {1, 0.0180}};
const Profile kPelvis = {{0, 0.0480}, {0.20, 0.0760}, {0.45, 0.0890}, {1, 0.0790}};
const Profile kSkirt = {{0, 0.0930}, {0.5, 0.0870}, {1, 0.0790}};
const Profile kChest = {{0, 0.0790},    {0.25, 0.0820}, {0.55, 0.0955}, {0.75, 0.1040},
                        {0.85, 0.0985}, {0.92, 0.0640}, {1, 0.0320}};
const Profile kNeck = {{0, 0.0330}, {0.4, 0.0270}, {1, 0.0270}};
const Profile kCollar = {{0, 0.0050}, {0.5, 0.0190}, {1, 0.0268}};

const Profile kStick = {{0, 0.0045}, {1, 0.0045}};

// Of the flags, in units of the body's height.
constexpr double kFlagSide = 1.0 / 6;
const Profile kFlag = {{0, kFlagSide / 2}, {1, kFlagSide / 2}};

cv::Point2d seen_at(const Stage& stage, cv::Point2d shift, const Vector3d& p) {
  return {stage.centre_x + shift.x + stage.unit * p.x(), stage.floor_y + shift.y - stage.unit * p.y()};
}

Vector3d chin_of(const body::Skeleton& s) { return s.skull - s.head_axes.col(1) * (body::vitruvian::kHeadHeight / 2); }

class Figure {
 public:
  Figure(Brush& brush, const body::Pose& pose, const Look& look, const Stage& stage, cv::Point2d shift)
      : brush_(brush),
        s_(body::skeleton_of(pose)),
        look_(look),
        stage_(stage),
        shift_(shift),
        scale_(body::scale_of(look.build)) {}

  [[nodiscard]] cv::Rect box() const {
    double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
    const auto take = [&](const Vector3d& p) {
      const auto q = at(p);
      left = std::min(left, q.x);
      right = std::max(right, q.x);
      top = std::min(top, q.y);
      bottom = std::max(bottom, q.y);
    };
    for (const auto side : {kLeft, kRight}) {
      for (const auto* p : {&s_.shoulder[side], &s_.elbow[side], &s_.fingertip[side], &s_.hip[side], &s_.knee[side],
                            &s_.ankle[side], &s_.heel[side], &s_.toe[side]}) {
        take(*p);
      }
      if (look_.flags) take(flag_end(side));
    }
    take(s_.crown);
    // No part is thicker beyond its joints.
    const double margin = (look_.flags ? kFlagSide : 0.08) * stage_.unit + 2;
    const cv::Rect wanted(
        cv::Point(static_cast<int>(std::floor(left - margin)), static_cast<int>(std::floor(top - margin))),
        cv::Point(static_cast<int>(std::ceil(right + margin)), static_cast<int>(std::ceil(bottom + margin))));
    return wanted & cv::Rect(0, 0, stage_.size.width, stage_.size.height);
  }

  void draw() {
    plan();
    std::stable_sort(parts_.begin(), parts_.end(), [](const auto& a, const auto& b) { return a.depth < b.depth; });
    for (const auto& part : parts_) part.draw();
  }

 private:
  struct Part {
    double depth;  // towards the viewer
    std::function<void()> draw;
  };

  [[nodiscard]] cv::Point2d at(const Vector3d& p) const { return seen_at(stage_, shift_, p); }

  void part(double depth, std::function<void()> draw) { parts_.push_back({depth, std::move(draw)}); }

  enum class Ends {
    kRound,
    kHem,  // cut at its second end, unless it points at the viewer
    kCutFirst,
    kCutSecond,
    kCutBoth,
  };

  void limb(const Vector3d& a, const Vector3d& b, const Profile& profile, double thickness, const cv::Vec3f& colour,
            Ends ends = Ends::kRound, double light = 1, double roundness = 1) {
    const auto from = at(a);
    const auto to = at(b);
    const double scale = stage_.unit * thickness;
    // A limb that points at the viewer would be all cut end: round it.
    const bool pointed = ends == Ends::kHem && std::hypot(to.x - from.x, to.y - from.y) < 3 * scale * profile.at(0.5);
    const bool round_a = ends == Ends::kRound || ends == Ends::kHem || ends == Ends::kCutSecond;
    const bool round_b = ends == Ends::kRound || ends == Ends::kCutFirst || pointed;
    brush_.draw({from, to, &profile, scale, round_a, round_b, colour, light, roundness});
  }

  // How wide an elliptic trunk looks whose depth is a share of its width.
  [[nodiscard]] static double seen_width(const Eigen::Matrix3d& axes, double depth) {
    return std::hypot(axes(0, 0), depth * axes(0, 2)) / std::max(0.3, std::hypot(axes(0, 1), axes(1, 1)));
  }

  void plan() {
    plan_trunk();
    for (const auto side : {kLeft, kRight}) {
      plan_leg(side);
      plan_arm(side);
    }
  }

  void plan_trunk() {
    constexpr double kDepth = 0.66;
    const double hips = scale_.trunk * seen_width(s_.pelvis_axes, 0.8);
    const double chest = scale_.trunk * seen_width(s_.chest_axes, kDepth);
    const Vector3d up = s_.chest_axes.col(1);
    const double middle = s_.pelvis.z();
    part(middle - 0.065, [=, this] {
      limb(s_.pelvis - s_.pelvis_axes.col(1) * 0.044, s_.waist, kPelvis, hips, look_.trousers, Ends::kCutBoth);
    });
    part(middle - 0.003, [=, this] {
      limb(s_.neck - up * 0.02, s_.skull - s_.head_axes.col(1) * 0.035, kNeck, 1, look_.skin, Ends::kRound, 0.84);
    });
    part(middle + 0.010, [=, this] {
      limb(s_.pelvis + s_.pelvis_axes.col(1) * 0.012, s_.waist + up * 0.01, kSkirt, hips, look_.shirt, Ends::kCutFirst,
           1, 0.9);
      limb(s_.waist, s_.neck + up * 0.026, kChest, chest, look_.shirt, Ends::kCutBoth, 1, 0.9);
      for (const auto side : {kLeft, kRight}) {
        shoulder(side);
      }
      // An open collar, seen from the front only.
      if (s_.chest_axes(2, 2) > 0.3) {
        const Vector3d front = s_.chest_axes.col(2) * 0.06;
        limb(s_.neck - up * 0.026 + front, s_.neck + up * 0.055 + front, kCollar, s_.chest_axes(2, 2), look_.skin,
             Ends::kCutSecond, 0.86);
      }
    });
    part(std::max(middle, s_.skull.z()) + 0.012,
         [=, this] { draw_head(brush_, at(chin_of(s_)), at(s_.crown), s_.head_axes, stage_.unit, look_, kFaceMark); });
  }

  // From beside the neck to the arm, in the chest's light, so that no seam shows.
  void shoulder(body::Side side) {
    const Vector3d inner = s_.neck + (s_.shoulder[side] - s_.neck) * 0.22 + s_.chest_axes.col(1) * 0.014;
    const cv::Vec3f cloth = look_.shirt;
    const double sign = side == kLeft ? 1 : -1;
    const cv::Point2d aside(s_.chest_axes(0, 0), -s_.chest_axes(1, 0));
    brush_.draw({at(inner), at(drawn_shoulder(side)), &kShoulder, stage_.unit * scale_.limb, true, true, cloth},
                [=](double, double share) {
                  return cloth * light_on(aside, sign * std::clamp(0.25 + 0.6 * share, 0.0, 0.85));
                });
  }

  // A hanging arm draws the shoulder in, a raised one lifts it.
  [[nodiscard]] Vector3d drawn_shoulder(body::Side side) const {
    const Vector3d arm = (s_.elbow[side] - s_.shoulder[side]).normalized();
    const double hanging = -arm.dot(s_.chest_axes.col(1));
    const double sign = side == kLeft ? 1 : -1;
    return s_.shoulder[side] +
           s_.chest_axes * Vector3d(-sign * (0.012 + 0.010 * std::abs(hanging)), -0.010 * hanging - 0.006, 0);
  }

  void plan_arm(body::Side side) {
    const double depth = std::max(s_.elbow[side].z(), (s_.elbow[side].z() + s_.fingertip[side].z()) / 2);
    const double bias = s_.chest_axes(2, 2) > 0.5 ? 0.03 : 0.0;
    part(depth + bias, [=, this] {
      brush_.mark(kBareArmMark[side]);
      const Vector3d shoulder = drawn_shoulder(side);
      if (look_.sleeves == Sleeves::kNone) limb(shoulder, s_.elbow[side], kUpperArm, scale_.limb, look_.skin);
      const Vector3d thumb_root = s_.wrist[side] + (s_.fingertip[side] - s_.wrist[side]) * 0.22;
      const Vector3d thumb = s_.forearm_axes[side] * Vector3d(0, -0.036, 0.026);
      limb(thumb_root, thumb_root + thumb, kThumb, 1, look_.skin, Ends::kRound, 0.95);
      limb(s_.elbow[side], s_.fingertip[side], kForearm, 1, look_.skin);
      fingers(side);
      brush_.mark(1);
      if (look_.sleeves == Sleeves::kLong) {
        const Vector3d cuff = s_.wrist[side] + (s_.fingertip[side] - s_.wrist[side]) * 0.06;
        limb(s_.elbow[side], cuff, kLongSleeve, scale_.limb, look_.shirt, Ends::kHem, 1, 0.75);
      }
      if (look_.sleeves != Sleeves::kNone) {
        limb(shoulder, s_.elbow[side] + (s_.elbow[side] - shoulder) * 0.02, kSleeve, scale_.limb, look_.shirt,
             Ends::kHem, 1, 0.75);
      }
      if (look_.flags) flag(side);
    });
  }

  // How far the stick reaches, which continues the forearm.
  [[nodiscard]] Vector3d flag_end(body::Side side) const {
    return s_.wrist[side] + (s_.fingertip[side] - s_.wrist[side]).normalized() * (kFlagSide + 0.03);
  }

  // Red and yellow, divided from the stick's tip to the opposite corner, over the hand that holds it. Of an arm held
  // out to its own side the cloth is below.
  void flag(body::Side side) {
    const Vector3d along = (s_.fingertip[side] - s_.wrist[side]).normalized();
    const auto tip = at(flag_end(side));
    limb(s_.wrist[side], flag_end(side), kStick, 1, {92, 128, 160});
    const auto seen = tip - at(s_.wrist[side]);
    const double length = std::max(1e-9, std::hypot(seen.x, seen.y));
    const double sign = side == kLeft ? -1 : 1;
    const cv::Point2d below(sign * seen.y / length, -sign * seen.x / length);
    const cv::Point2d aside = below * (0.38 * kFlagSide * stage_.unit);
    const auto hoist = at(flag_end(side) - along * kFlagSide);
    const double fold = side == kLeft ? 1 : -1;
    brush_.draw({hoist + aside, tip + aside, &kFlag, stage_.unit, false, false, {}}, [=](double across, double share) {
      const bool red = fold * across > 2 * share - 1;
      const double ripple = 0.98 + 0.05 * std::sin(9 * share + 2 * across);
      return (red ? cv::Vec3f(36, 30, 204) : cv::Vec3f(24, 206, 246)) * ripple;
    });
  }

  // Three shaded lines between four fingers, fanned out a little towards the tips.
  void fingers(body::Side side) {
    const auto wrist = at(s_.wrist[side]);
    const cv::Point2d hand = at(s_.fingertip[side]) - wrist;
    const cv::Point2d aside(-hand.y, hand.x);
    for (const double finger : {-1.0, 0.0, 1.0}) {
      brush_.draw({wrist + 0.62 * hand + aside * (0.100 * finger), wrist + 0.94 * hand + aside * (0.075 * finger),
                   &kCrease, stage_.unit, true, true, look_.skin, 0.78});
    }
  }

  void plan_leg(body::Side side) {
    const double thigh = (s_.hip[side].z() + s_.knee[side].z()) / 2;
    const double shank = (s_.knee[side].z() + s_.ankle[side].z()) / 2;
    const double foot = std::min(s_.ankle[side].z(), shank) - 0.001;
    part(foot, [=, this] {
      const Vector3d lift = s_.foot_axes[side].col(1) * 0.020;
      limb(s_.heel[side] + lift, s_.toe[side] + lift * 0.9, kShoe, 1, look_.shoes);
      limb(s_.ankle[side], s_.heel[side] + lift + s_.foot_axes[side].col(2) * 0.04, kShoe, 1.05, look_.shoes);
    });
    part(shank, [=, this] {
      limb(s_.knee[side], s_.ankle[side] + (s_.knee[side] - s_.ankle[side]) * 0.03, kShank, scale_.limb, look_.trousers,
           Ends::kHem);
    });
    part(thigh - 0.06, [=, this] { limb(s_.hip[side], s_.knee[side], kThigh, scale_.limb, look_.trousers); });
  }

  Brush& brush_;
  body::Skeleton s_;
  const Look& look_;
  const Stage& stage_;
  cv::Point2d shift_;
  body::BuildScale scale_;
  std::vector<Part> parts_;
};

// More samples a pixel where the figure is small and every pixel counts.
int samples_for(double unit) {
  if (unit < 160) return 4;
  if (unit < 500) return 3;
  return 2;
}

}  // namespace

bool draw_figure(Brush& brush, const body::Pose& pose, const Look& look, const Stage& stage, cv::Point2d shift) {
  Figure figure(brush, pose, look, stage, shift);
  const auto box = figure.box();
  if (box.empty()) return false;
  brush.begin(box, samples_for(stage.unit));
  figure.draw();
  return true;
}

cv::Rect2d visible_face(const Brush& brush, const body::Pose& pose, const Stage& stage, cv::Point2d shift) {
  const auto s = body::skeleton_of(pose);
  const auto box = face_box(seen_at(stage, shift, chin_of(s)), seen_at(stage, shift, s.crown), s.head_axes, stage.unit);
  if (box.empty()) return {};
  const cv::Rect pixels =
      cv::Rect(cv::Point(cvFloor(box.x), cvFloor(box.y)), cv::Point(cvCeil(box.br().x), cvCeil(box.br().y))) &
      brush.box();
  double samples = 0;
  for (int y = pixels.y; y < pixels.br().y; ++y) {
    for (int x = pixels.x; x < pixels.br().x; ++x) samples += brush.marked(x, y, kFaceMark);
  }
  const double whole = 0.8 * box.area() * brush.samples_per_pixel();  // a skull fills four fifths of the box around it
  if (samples < whole / 2) return {};
  return box;
}

FloorShadow::FloorShadow(const body::Pose& pose, const Stage& stage, cv::Point2d shift) {
  constexpr double kDepth = 9;     // grey levels under a foot on the floor
  constexpr double kFades = 0.14;  // height in units of H at which a foot casts none
  constexpr double kFloorTop = 0.05;
  const auto s = body::skeleton_of(pose);
  double top = stage.size.height;
  double bottom = 0;
  for (const auto side : {kLeft, kRight}) {
    const Vector3d foot = (s.heel[side] + s.toe[side]) / 2;
    auto& patch = patches_[side];
    patch.centre = {stage.centre_x + shift.x + stage.unit * foot.x(), stage.floor_y + shift.y};
    patch.half_width = 0.085 * stage.unit + std::abs(s.toe[side].x() - s.heel[side].x()) / 2 * stage.unit;
    patch.half_height = 0.026 * stage.unit;
    patch.depth = kDepth * std::clamp(1 - foot.y() / kFades, 0.0, 1.0) * (1 << kLevelBits);
    top = std::min(top, std::max(patch.centre.y - patch.half_height, stage.floor_y + shift.y - kFloorTop * stage.unit));
    bottom = std::max(bottom, patch.centre.y + patch.half_height);
  }
  rows_ = {std::max(0, static_cast<int>(std::ceil(top))), std::min(stage.size.height, static_cast<int>(bottom))};
}

void FloorShadow::darken(int y, std::vector<int>& row) const {
  const int width = static_cast<int>(row.size() / 3);
  for (const auto& p : patches_) {
    const double v = (y + 0.5 - p.centre.y) / p.half_height;
    const int from = std::max(0, static_cast<int>(p.centre.x - p.half_width));
    const int to = std::min(width, static_cast<int>(p.centre.x + p.half_width) + 1);
    for (int x = from; x < to; ++x) {
      const double u = (x + 0.5 - p.centre.x) / p.half_width;
      const double away = u * u + v * v;
      if (away >= 1) continue;
      const int dark = static_cast<int>(p.depth * (1 - away) * (1 - away));
      for (int c = 0; c < 3; ++c) row[static_cast<std::size_t>(x) * 3 + static_cast<std::size_t>(c)] -= dark;
    }
  }
}

}  // namespace choreo::devices::synthetic
