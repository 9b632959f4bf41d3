// SPDX-License-Identifier: Apache-2.0
// Stretches of a clip in which the whole picture stands still: the empty room is among them, if it was ever shown.
#pragma once

#include <cstddef>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace choreo::vision {

/// Finds them while the frames pass, and keeps the mean picture of the longest, and of the first and the last however
/// short: a room is empty before and after.
/// @thread thread-bound
class QuietStretches {
 public:
  /// @param picture  CV_8UC3, all of one size.  @param time_s  seconds, increasing.
  void add(const cv::Mat& picture, double time_s);

  /// The mean pictures, the longest stretch first. Ends the stretch under way.
  [[nodiscard]] std::vector<cv::Mat> finish();

 private:
  struct Stretch {
    double length_s;
    int number;  // In time.
    cv::Mat mean;
  };
  void end_stretch();

  cv::Mat first_small_;  // Of the stretch under way, blurred and reduced.
  cv::Mat sum_;          // CV_32SC3.
  int count_ = 0;
  double begin_s_ = 0;
  double last_s_ = 0;
  int ended_ = 0;
  std::vector<Stretch> found_;
};

}  // namespace choreo::vision
