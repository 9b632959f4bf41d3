// SPDX-License-Identifier: Apache-2.0
#include "pipeline/arm_fit.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <opencv2/imgproc.hpp>

namespace choreo::pipeline {
namespace {

using body::kLeft;
using body::kRight;
using body::Side;

// In torsos.
constexpr double kEvidence = 960, kCore = 0.1, kFar = 0.3;
constexpr double kUpperLength = 0.5, kForeLength = 0.45, kTellingLength = 0.3;
constexpr double kLengthError = 0.3;  // Of the logarithm.
constexpr double kRadians = std::numbers::pi / 180;
constexpr double kTurnError = 14 * kRadians, kBend = 60 * kRadians;
constexpr std::size_t kStarts = 3;
constexpr int kGrid = 2;  // Pixels.

double square(double x) { return x * x; }
double apart(double a, double b) { return std::remainder(a - b, 2 * std::numbers::pi); }

using Bone = std::pair<cv::Point2d, cv::Point2d>;
std::array<Bone, 2> drawn(const Arm& arm) { return {Bone(arm[0], arm[1]), Bone(arm[1], hand_of(arm))}; }

double distance(cv::Point2d p, const Bone& bone) {
  const auto along = bone.second - bone.first, to = p - bone.first;
  const double length = along.dot(along);
  const double share = length > 0 ? std::clamp(to.dot(along) / length, 0.0, 1.0) : 0;
  return cv::norm(to - share * along);
}

}  // namespace

ArmFit::ArmFit(const cv::Mat& limbs, const cv::Mat& silhouette, double torso, const std::vector<Arms>& seen)
    : torso_(torso) {
  assert(!seen.empty() && torso > 0 && limbs.size() == silhouette.size());
  for (int y = 0; y < limbs.rows; y += kGrid) {
    for (int x = 0; x < limbs.cols; x += kGrid) {
      if (limbs.at<uchar>(y, x) != 0) limbs_.emplace_back(x, y);
    }
  }
  cv::distanceTransform(~silhouette, outside_, cv::DIST_L2, cv::DIST_MASK_3);
  for (const auto side : {kLeft, kRight}) {
    for (const auto& arms : seen) {
      shoulders_[side] += arms[side][0] / double(seen.size());
      seen_[side].push_back(bones_of(arms[side]));
    }
  }
}

ArmFit::Bones ArmFit::bones_of(const Arm& arm) const {
  const auto upper = arm[1] - arm[0], fore = arm[2] - arm[1];
  return {std::atan2(upper.y, upper.x), cv::norm(upper) / torso_, std::atan2(fore.y, fore.x), cv::norm(fore) / torso_};
}

Arm ArmFit::arm_of(Side side, const Bones& bones) const {
  const auto along = [this](double direction, double length) {
    return length * torso_ * cv::Point2d(std::cos(direction), std::sin(direction));
  };
  const auto& shoulder = shoulders_[side];
  const auto elbow = shoulder + along(bones.upper, bones.upper_length);
  return {shoulder, elbow, elbow + along(bones.fore, bones.fore_length)};
}

// Squares of what an arm is turned from where it is seen, in the error of that.
double ArmFit::turned(Side side, const Bones& bones) const {
  double nearest = std::numeric_limits<double>::max();
  for (const auto& one : seen_[side]) {
    const double tells = std::min(1.0, one.upper_length / kTellingLength);
    nearest = std::min(nearest, tells * square(apart(bones.upper, one.upper)) + square(apart(bones.fore, one.fore)));
  }
  return nearest / square(kTurnError);
}

// An arm's by itself.
double ArmFit::unlikely(Side side, const Bones& bones) const {
  return (turned(side, bones) + square(apart(bones.upper, bones.fore) / kBend) +
          square(std::log(bones.upper_length / kUpperLength) / kLengthError) +
          square(std::log(bones.fore_length / kForeLength) / kLengthError)) /
         2;
}

double ArmFit::outside(const Arm& arm) const {
  const cv::Rect whole({}, outside_.size());
  double sum = 0;
  for (const auto& [a, b] : drawn(arm)) {
    const double length = cv::norm(b - a);
    const int steps = std::max(1, int(length / kGrid));
    for (int k = 0; k <= steps; ++k) {
      const cv::Point p = a + (b - a) * (double(k) / steps);
      const double d = whole.contains(p) ? double(outside_.at<float>(p)) / torso_ : kFar;
      sum += square(std::min(d, kFar)) * length / steps;
    }
  }
  return sum / torso_;
}

double ArmFit::cost_of(const BothBones& bones) const {
  const auto left = arm_of(kLeft, bones[kLeft]), right = arm_of(kRight, bones[kRight]);
  const auto left_drawn = drawn(left), right_drawn = drawn(right);
  double beside = 0;
  for (const auto& p : limbs_) {
    const double nearest = std::min({distance(p, left_drawn[0]), distance(p, left_drawn[1]),
                                     distance(p, right_drawn[0]), distance(p, right_drawn[1])});
    beside += square(std::clamp(nearest / torso_ - kCore / 2, 0.0, kFar));
  }
  beside *= square(kGrid / torso_);
  const double off = kCore * (outside(left) + outside(right));
  return kEvidence * (beside + off) + unlikely(kLeft, bones[kLeft]) + unlikely(kRight, bones[kRight]);
}

// One arm at a time: the upper arm turns, the forearm, both, one of them becomes longer or shorter.
double ArmFit::descend(BothBones& bones, double cost) const {
  constexpr int kMoves = 5, kSweeps = 4;
  constexpr double kLonger = 0.015;  // Instead of a degree, of the logarithm.
  const auto moved = [](Bones b, int move, double degrees) {
    if (move == 0 || move == 2) b.upper += degrees * kRadians;
    if (move == 1 || move == 2) b.fore += degrees * kRadians;
    if (move == 3) b.upper_length *= std::exp(kLonger * degrees);
    if (move == 4) b.fore_length *= std::exp(kLonger * degrees);
    return b;
  };
  for (const double step : {8, 4, 2, 1}) {
    bool better = true;
    for (int sweep = 0; better && sweep < kSweeps; ++sweep) {
      better = false;
      for (const auto side : {kLeft, kRight}) {
        for (int move = 0; move < 2 * kMoves; ++move) {
          auto next = bones;
          next[side] = moved(bones[side], move / 2, move % 2 == 0 ? -step : step);
          const double less = cost_of(next);
          if (less >= cost) continue;
          bones = next;
          cost = less;
          better = true;
        }
      }
    }
  }
  return cost;
}

Arms ArmFit::best() const {
  struct Fitted {
    BothBones bones;
    double cost;
  };
  std::vector<Fitted> pairs;
  for (const auto& left : seen_[kLeft]) {
    for (const auto& right : seen_[kRight]) pairs.push_back({{left, right}, cost_of({left, right})});
  }
  std::ranges::stable_sort(pairs, {}, &Fitted::cost);
  pairs.resize(std::min(pairs.size(), kStarts));
  for (auto& [bones, cost] : pairs) cost = descend(bones, cost);
  const auto& bones = std::ranges::min_element(pairs, {}, &Fitted::cost)->bones;
  return {arm_of(kLeft, bones[kLeft]), arm_of(kRight, bones[kRight])};
}

std::size_t ArmFit::nearest(Side side, const Arm& arm) const {
  const double fore = bones_of(arm).fore;
  const auto nearest =
      std::ranges::min_element(seen_[side], {}, [&](const auto& one) { return std::abs(apart(one.fore, fore)); });
  return std::size_t(nearest - seen_[side].begin());
}

double ArmFit::trust(Side side, const Arm& arm) const {
  constexpr double kDoubtful = 8;  // Two errors of the upper arm and two of the forearm.
  return 1 / (1 + square(turned(side, bones_of(arm)) / kDoubtful));
}

}  // namespace choreo::pipeline
