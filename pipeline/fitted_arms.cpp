// SPDX-License-Identifier: Apache-2.0
#include "pipeline/fitted_arms.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <iterator>
#include <span>
#include <utility>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "body/figure.hpp"
#include "pipeline/arm_fit.hpp"

namespace choreo::pipeline {
namespace {

using body::kLeft;
using body::kRight;
using vision::PersonLook;
using Name = vision::PersonPointName;

// A small picture about the shoulders, in which a torso is so long.
constexpr double kTorso = 40;
constexpr int kCanvasSide = 160;
constexpr int kLikely = 60;  // Of 255, the looks' mean.

// In torsos.
constexpr double kTrunk = 0.16, kHead = 0.33, kHeadAbove = 0.42, kNeck = 0.25, kLeg = 0.4;
constexpr double kReach = 1.25;               // What an arm and a hand reach.
constexpr double kWide = 0.34, kThin = 0.12;  // What an arm explains, and what of it has to be seen.
constexpr double kNothing = 0.05;             // Torsos squared: so little is no limb.
constexpr double kOffWeight = 2.5;            // Of thin arms outside, which are so much smaller.

constexpr std::array<std::array<Name, 3>, 2> kJoints = {{{Name::kLeftShoulder, Name::kLeftElbow, Name::kLeftWrist},
                                                         {Name::kRightShoulder, Name::kRightElbow, Name::kRightWrist}}};

// Takes places of the picture to the small one.
struct Canvas {
  static inline const cv::Point2d kMiddle{kCanvasSide / 2.0, kCanvasSide / 2.0};
  cv::Point2d shoulders;
  double scale = 0;

  [[nodiscard]] cv::Point2d operator()(cv::Point2d p) const { return (p - shoulders) * scale + kMiddle; }
  [[nodiscard]] cv::Point2d back(cv::Point2d p) const { return (p - kMiddle) / scale + shoulders; }
};

void draw(cv::Mat& on, cv::Point2d a, cv::Point2d b, double torsos) {
  cv::line(on, a, b, 255, std::max(1, cvRound(torsos * kTorso)), cv::LINE_8);
}

void draw(cv::Mat& on, const Arm& arm, double torsos) {
  draw(on, arm[0], arm[1], torsos);
  draw(on, arm[1], hand_of(arm), torsos);
}

cv::Mat nothing() { return cv::Mat::zeros(kCanvasSide, kCanvasSide, CV_8UC1); }

// Trunk, head, legs and what is between these.
cv::Mat body_of(const PersonLook& look, const Canvas& canvas) {
  const auto at = [&](Name name) { return canvas(look[name].at); };
  const auto fill = [](cv::Mat& on, const std::array<cv::Point2d, 4>& corners) {
    std::vector<cv::Point> whole;
    for (const auto& p : corners) whole.emplace_back(cvRound(p.x), cvRound(p.y));
    cv::fillConvexPoly(on, whole, 255);
  };
  cv::Mat out = nothing();
  const std::array trunk = {at(Name::kLeftShoulder), at(Name::kRightShoulder), at(Name::kRightHip), at(Name::kLeftHip)};
  fill(out, trunk);
  for (std::size_t k = 0; k < 4; ++k) draw(out, trunk[k], trunk[(k + 1) % 4], kTrunk);
  const auto shoulders = (trunk[0] + trunk[1]) / 2, up = (shoulders - (trunk[2] + trunk[3]) / 2) / kTorso;
  const auto head = shoulders + kHeadAbove * kTorso * up;
  cv::circle(out, head, cvRound(kHead * kTorso), 255, cv::FILLED);
  draw(out, shoulders, head, kNeck);
  for (const auto& [hip, knee, ankle] : {std::array{Name::kLeftHip, Name::kLeftKnee, Name::kLeftAnkle},
                                         {Name::kRightHip, Name::kRightKnee, Name::kRightAnkle}}) {
    draw(out, at(hip), at(knee), kLeg);
    draw(out, at(knee), at(ankle), kLeg);
  }
  draw(out, trunk[2], trunk[3], kLeg);
  fill(out, {trunk[3], at(Name::kLeftAnkle), at(Name::kRightAnkle), trunk[2]});
  return out;
}

// The mean of the silhouettes.
cv::Mat silhouette_of(const std::vector<ArmLook>& looks, cv::Size picture, const Canvas& canvas) {
  cv::Mat sum = cv::Mat::zeros(kCanvasSide, kCanvasSide, CV_32FC1);
  for (const auto& [look, flipped] : looks) {
    const auto region = look.region.from_picture(look.silhouette.cols);
    const double turn = flipped ? -1 : 1, offset = flipped ? picture.width - 1 : 0;
    // From the canvas to the picture, its mirror image, the region.
    const double back = 1 / canvas.scale;
    const auto x0 = canvas.shoulders.x - back * kCanvasSide / 2, y0 = canvas.shoulders.y - back * kCanvasSide / 2;
    const cv::Matx33d to_picture(turn * back, 0, offset + turn * x0, 0, back, y0, 0, 0, 1);
    cv::Mat one;
    cv::warpAffine(look.silhouette, one, cv::Mat(region * to_picture), sum.size(),
                   cv::INTER_LINEAR | cv::WARP_INVERSE_MAP);
    cv::accumulate(one, sum);
  }
  return sum > kLikely * double(looks.size());
}

Arms arms_of(const ArmLook& seen, cv::Size picture, const Canvas& canvas) {
  Arms out;
  for (const auto side : {kLeft, kRight}) {
    for (std::size_t k = 0; k < 3; ++k) {
      auto p = seen.look[kJoints[side][k]].at;
      if (seen.flipped) p.x = picture.width - 1 - p.x;
      out[seen.flipped ? 1 - side : side][k] = canvas(p);
    }
  }
  return out;
}

// The share of the limbs that two arms explain.
double explained_by(const Arms& arms, const cv::Mat& limbs, const cv::Mat& silhouette) {
  cv::Mat wide = nothing(), thin = nothing();
  for (const auto& arm : arms) {
    draw(wide, arm, kWide);
    draw(thin, arm, kThin);
  }
  const double here = cv::countNonZero(limbs & wide) + kNothing * kTorso * kTorso;
  return here / (here + cv::countNonZero(limbs & ~wide) + kOffWeight * cv::countNonZero(thin & ~silhouette));
}

bool counts(const ArmLook& seen) {
  const auto& look = seen.look;
  const auto has_length = [&](Name a, Name b) { return look[a].at != look[b].at; };
  return !look.silhouette.empty() && !look.faces_away() && std::ranges::all_of(kJoints, [&](const auto& joints) {
    return has_length(joints[0], joints[1]) && has_length(joints[1], joints[2]);
  });
}

}  // namespace

std::vector<ArmLook> looks_for_arms(const cv::Mat& picture, const PersonLook& look, vision::PersonSearch& people,
                                    std::size_t count) {
  constexpr double kLarger = 1.25;
  struct Kind {
    bool flipped;
    double larger;
  };
  constexpr std::array kKinds = {Kind{true, kLarger}, Kind{false, kLarger}, Kind{true, 1}};  // Those that help first.
  assert(count >= 1 && count <= kKinds.size() + 1);
  std::vector<ArmLook> looks = {{look, false}};
  cv::Mat mirror;
  if (count > 1) cv::flip(picture, mirror, 1);
  for (const auto& [flipped, larger] : std::span(kKinds).first(count - 1)) {
    auto region = flipped ? look.next.flipped(picture.cols) : look.next;
    region.side *= larger;
    if (auto seen = people.look(flipped ? mirror : picture, region)) looks.push_back({*std::move(seen), flipped});
  }
  return looks;
}

PersonLook fitted_arms(std::span<const ArmLook> all, cv::Size picture) {
  assert(!all.empty() && !all.front().flipped);
  auto out = all.front().look;
  const auto shoulders = (out[Name::kLeftShoulder].at + out[Name::kRightShoulder].at) / 2;
  const auto hips = (out[Name::kLeftHip].at + out[Name::kRightHip].at) / 2;
  const double torso = cv::norm(shoulders - hips);
  if (torso <= 0 || !counts(all.front())) return out;
  std::vector<ArmLook> looks;
  std::ranges::copy_if(all, std::back_inserter(looks), counts);
  const Canvas canvas{shoulders, kTorso / torso};
  const auto silhouette = silhouette_of(looks, picture, canvas);
  cv::Mat within_reach = nothing();
  for (const auto& shoulder : {Name::kLeftShoulder, Name::kRightShoulder}) {
    cv::circle(within_reach, canvas(out[shoulder].at), cvRound(kReach * kTorso), 255, cv::FILLED);
  }
  const cv::Mat limbs = silhouette & ~body_of(out, canvas) & within_reach;

  std::vector<Arms> seen;
  for (const auto& look : looks) seen.push_back(arms_of(look, picture, canvas));
  const ArmFit fit(limbs, silhouette, kTorso, seen);
  const auto arms = fit.best();
  constexpr double kWell = 0.5, kHardly = 0.3;
  const double trust = std::clamp((explained_by(arms, limbs, silhouette) - kHardly) / (kWell - kHardly), 0.0, 1.0);
  for (const auto side : {kLeft, kRight}) {
    // How well it is seen by the look that is nearest.
    const auto& look = looks[fit.nearest(side, arms[side])];
    const auto& theirs = kJoints[look.flipped ? 1 - side : side];
    for (std::size_t k = 0; k < 3; ++k) {
      auto& joint = out.points[std::size_t(kJoints[side][k])];
      joint.at = canvas.back(arms[side][k]);
      joint.visibility = look.look[theirs[k]].visibility;
    }
    out.points[std::size_t(kJoints[side][2])].visibility *= trust * fit.trust(side, arms[side]);
  }
  return out;
}

}  // namespace choreo::pipeline
