// SPDX-License-Identifier: Apache-2.0
// Keeps some pictures of what passed, for telling wall and body apart while frames come in.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "vision/unseen_wall.hpp"

namespace choreo::vision {

/// Decides which pictures to keep and when to ask what the wall is, and works at the answer a step a frame.
///
/// At first it asks often, since every limb that moves away shows a piece of wall; then ever more rarely. An answer
/// comes some thirty frames after it was asked for: no frame has to wait for it, and the same frames give the same
/// answers at the same frames.
/// @thread thread-bound
class WallLearner {
 public:
  /// @param noise  standard deviation of the sensor's noise in D, grey levels.
  explicit WallLearner(double noise) : noise_(noise) {}

  /// @param picture  CV_8UC3, all of one size.  @param time_s  seconds, increasing.
  /// @param background  CV_8UC3, in whose light the pictures are brought.  @param except  as of `ToneCurve`.
  /// @return what the wall is where an answer was found with this frame, else nothing.
  [[nodiscard]] std::optional<InferredWall> add(const cv::Mat& picture, double time_s, const cv::Mat& background,
                                                const cv::Mat& except);

  /// Forgets everything: the scene is another.
  void reset() { *this = WallLearner(noise_); }

 private:
  struct Kept {
    double time_s;
    std::uint64_t lot;  // The lower, the sooner it goes.
    cv::Mat picture;
  };
  void keep(const cv::Mat& picture, double time_s);

  double noise_;
  std::vector<Kept> kept_;
  std::uint64_t offered_ = 0;
  std::optional<double> first_s_, last_s_;
  double next_ask_s_ = 2.0;
  std::optional<WallInference> inference_;
};

}  // namespace choreo::vision
