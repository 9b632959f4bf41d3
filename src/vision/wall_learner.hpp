// SPDX-License-Identifier: Apache-2.0
// Keeps some pictures of what passed, for telling wall and body apart while frames come in.
#pragma once

#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "vision/background_estimate.hpp"

namespace choreo::vision {

/// Decides which pictures to keep and when to ask what the wall is.
///
/// At first it asks often, since every limb that moves away shows a piece of wall; then ever more rarely.
/// @thread thread-bound
class WallLearner {
 public:
  /// @param picture  CV_8UC3, all of one size.  @param time_s  seconds, increasing.
  /// @param background  CV_8UC3, in whose light the pictures are brought.  @param except  as of `ToneCurve`.
  void add(const cv::Mat& picture, double time_s, const cv::Mat& background, const cv::Mat& except);

  /// Whether it is time to ask.
  [[nodiscard]] bool due() const { return due_; }

  /// What is known by now, given what was thought of the background so far.
  /// @cost  as of `infer_wall` with at most 40 pictures: 0.3 s or more at 160 x 120 on a busy machine; asked at 2 s, 3 s, 5 s,
  ///   8 s, ..., at last every 20 s.
  [[nodiscard]] BackgroundEstimate ask(BackgroundEstimate so_far);

 private:
  std::vector<cv::Mat> kept_;
  double period_s_ = 0.1;
  std::optional<double> first_s_, last_s_;
  double next_ask_s_ = 2.0;
  bool due_ = false;
};

}  // namespace choreo::vision
