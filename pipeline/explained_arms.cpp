// SPDX-License-Identifier: Apache-2.0
#include "pipeline/explained_arms.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "pipeline/seen_arms.hpp"

namespace choreo::pipeline {
namespace {

using body::ArmPoses;
using body::kLeft;
using body::kRight;
using vision::PersonLook;
using Name = vision::PersonPointName;

// A small picture about the shoulders, in which a torso is so long.
constexpr double kTorso = 40;
constexpr int kCanvasSide = 160;

// In torsos.
constexpr double kTrunk = 0.22, kHead = 0.33, kHeadAbove = 0.42, kNeck = 0.25, kLeg = 0.5;
constexpr double kReach = 1.6;                // What an arm and a hand reach.
constexpr double kWide = 0.34, kThin = 0.12;  // What an arm explains, and what of it has to be seen.
constexpr double kHand = 0.35;                // Of the forearm, beyond the wrist.
constexpr double kNothing = 0.05;             // Torsos squared: so little is no limb.

constexpr double kOffWeight = 2.5;  // Of thin arms outside, which are so much smaller.
constexpr double kOneLook = 0.02;   // What arms of one look are better by.
constexpr double kAsGood = 0.06;
constexpr double kAlikeDegrees = 30;
constexpr int kLikely = 110;  // Of 255.

using Arm = std::array<cv::Point2d, 3>;  // Shoulder, elbow, wrist.

// Takes places of the picture to the small one.
struct Canvas {
  cv::Point2d shoulders;
  double scale = 0;

  [[nodiscard]] cv::Point2d operator()(cv::Point2d p) const {
    return (p - shoulders) * scale + cv::Point2d(kCanvasSide / 2.0, kCanvasSide / 2.0);
  }
};

void draw(cv::Mat& on, cv::Point2d a, cv::Point2d b, double torsos) {
  cv::line(on, a, b, 255, std::max(1, cvRound(torsos * kTorso)), cv::LINE_8);
}

void draw(cv::Mat& on, const Arm& arm, double torsos) {
  draw(on, arm[0], arm[1], torsos);
  draw(on, arm[1], arm[2] + kHand * (arm[2] - arm[1]), torsos);
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
cv::Mat silhouette_of(std::span<const ArmLook> looks, cv::Size picture, const Canvas& canvas) {
  cv::Mat sum = cv::Mat::zeros(kCanvasSide, kCanvasSide, CV_32FC1);
  for (const auto& [look, flipped] : looks) {
    if (look.silhouette.empty()) return {};
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

std::array<Arm, 2> arms_of(const ArmLook& seen, cv::Size picture, const Canvas& canvas) {
  const auto at = [&](Name name) {
    auto p = seen.look[name].at;
    if (seen.flipped) p.x = picture.width - 1 - p.x;
    return canvas(p);
  };
  std::array<Arm, 2> out;
  out[kLeft] = {at(Name::kLeftShoulder), at(Name::kLeftElbow), at(Name::kLeftWrist)};
  out[kRight] = {at(Name::kRightShoulder), at(Name::kRightElbow), at(Name::kRightWrist)};
  if (seen.flipped) std::swap(out[kLeft], out[kRight]);
  return out;
}

// The share of the limbs that two arms explain.
double explained_by(const Arm& left, const Arm& right, const cv::Mat& limbs, const cv::Mat& silhouette) {
  cv::Mat wide = nothing(), thin = nothing();
  for (const auto& arm : {left, right}) {
    draw(wide, arm, kWide);
    draw(thin, arm, kThin);
  }
  const double here = cv::countNonZero(limbs & wide) + kNothing * kTorso * kTorso;
  return here / (here + cv::countNonZero(limbs & ~wide) + kOffWeight * cv::countNonZero(thin & ~silhouette));
}

bool alike(const body::ArmPose& a, const body::ArmPose& b) {
  return std::abs(body::turn(a.fore, b.fore)) < kAlikeDegrees;
}

}  // namespace

ArmPoses explained_arms(std::span<const ArmLook> looks, cv::Size picture, bool mirrored) {
  assert(!looks.empty() && !looks.front().flipped);
  std::vector<ArmPoses> seen;
  for (const auto& [look, flipped] : looks) seen.push_back(arm_poses(look, picture, mirrored != flipped));
  const auto& first = looks.front().look;
  const auto shoulders = (first[Name::kLeftShoulder].at + first[Name::kRightShoulder].at) / 2;
  const auto hips = (first[Name::kLeftHip].at + first[Name::kRightHip].at) / 2;
  const double torso = cv::norm(shoulders - hips);
  if (torso <= 0) return seen.front();
  const Canvas canvas{shoulders, kTorso / torso};
  const auto silhouette = silhouette_of(looks, picture, canvas);
  if (silhouette.empty()) return body::mean_of(seen);
  cv::Mat within_reach = nothing();
  cv::circle(within_reach, {kCanvasSide / 2, kCanvasSide / 2}, cvRound(kReach * kTorso), 255, cv::FILLED);
  const cv::Mat limbs = silhouette & ~body_of(first, canvas) & within_reach;

  std::vector<std::array<Arm, 2>> arms;
  for (const auto& look : looks) arms.push_back(arms_of(look, picture, canvas));
  // A mirror image of a mirror image: sides of `arms` are the picture's, those of `seen` the signaller's.
  const auto side = [mirrored](body::Side s) { return mirrored ? (s == kLeft ? kRight : kLeft) : s; };
  struct Pair {
    ArmPoses poses;
    double explained;
  };
  std::vector<Pair> pairs;
  for (std::size_t l = 0; l < looks.size(); ++l) {
    for (std::size_t r = 0; r < looks.size(); ++r) {
      if (!seen[l][kLeft] || !seen[r][kRight]) continue;
      const double explained =
          explained_by(arms[l][side(kLeft)], arms[r][side(kRight)], limbs, silhouette) + (l == r ? kOneLook : 0);
      pairs.push_back({{seen[l][kLeft], seen[r][kRight]}, explained});
    }
  }
  if (pairs.empty()) return {};
  const auto best = *std::ranges::max_element(pairs, {}, &Pair::explained);
  std::vector<ArmPoses> good;
  for (const auto& [poses, explained] : pairs) {
    const bool as_good = explained >= best.explained - kAsGood;
    if (as_good && alike(*poses[kLeft], *best.poses[kLeft]) && alike(*poses[kRight], *best.poses[kRight])) {
      good.push_back(poses);
    }
  }
  auto out = body::mean_of(good);
  constexpr double kWell = 0.5, kHardly = 0.3;
  const double trust = std::clamp((best.explained - kHardly) / (kWell - kHardly), 0.0, 1.0);
  for (auto& arm : out) arm->seen *= trust;
  return out;
}

}  // namespace choreo::pipeline
