// SPDX-License-Identifier: Apache-2.0
// Two arms drawn along the limbs of a silhouette, from where they were seen.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include "body/figure.hpp"

namespace choreo::pipeline {

/// Shoulder, elbow and wrist in a picture.
using Arm = std::array<cv::Point2d, 3>;
/// Of each body::Side.
using Arms = std::array<Arm, 2>;

/// Where the hand ends: beyond the wrist by a third of the forearm.
[[nodiscard]] inline cv::Point2d hand_of(const Arm& arm) { return arm[2] + 0.35 * (arm[2] - arm[1]); }

/// Least squares, lengths in torsos. A place of the limbs costs 960 d^2 times its area where d is how far it lies beside
/// the nearer arm, 0.1 wide, 0.3 at most; an arm costs 96 d^2 times its length where it lies d outside of the
/// silhouette; upper arm and forearm cost half the squares of what they are off the nearest of those seen (in 14
/// degrees each; less of an upper arm that is seen shorter than 0.3), off their usual lengths of 0.5 and 0.45 (ln, in
/// 0.3), and off straight (in 60 degrees).
/// @thread reentrant
class ArmFit {
 public:
  /// @param limbs, silhouette  CV_8UC1 of one size, not 0 where something is.  @param torso  in pixels.
  /// @param seen  at least one, in pixels; no upper arm and no forearm of no length.
  ArmFit(const cv::Mat& limbs, const cv::Mat& silhouette, double torso, const std::vector<Arms>& seen);

  /// By descent from the three best pairs of a left and a right arm of whichever are seen, the shoulders at their mean.
  [[nodiscard]] Arms best() const;

  /// Which of the seen has the forearm most alike.
  [[nodiscard]] std::size_t nearest(body::Side side, const Arm& arm) const;

  /// That the arm is there, 0 to 1: less the further it was turned from where it is seen; one half where by 28 degrees,
  /// upper arm and forearm.
  [[nodiscard]] double trust(body::Side side, const Arm& arm) const;

 private:
  // Upper arm and forearm by where they point in the picture, radians, and how long they are there, torsos.
  struct Bones {
    double upper, upper_length, fore, fore_length;
  };
  using BothBones = std::array<Bones, 2>;

  [[nodiscard]] Bones bones_of(const Arm& arm) const;
  [[nodiscard]] Arm arm_of(body::Side side, const Bones& bones) const;
  [[nodiscard]] double turned(body::Side side, const Bones& bones) const;
  [[nodiscard]] double unlikely(body::Side side, const Bones& bones) const;
  [[nodiscard]] double outside(const Arm& arm) const;
  [[nodiscard]] double cost_of(const BothBones& bones) const;
  double descend(BothBones& bones, double cost) const;

  double torso_;
  std::vector<cv::Point2d> limbs_;
  cv::Mat outside_;  // CV_32FC1, pixels from the silhouette.
  std::array<cv::Point2d, 2> shoulders_;
  std::array<std::vector<Bones>, 2> seen_;
};

}  // namespace choreo::pipeline
