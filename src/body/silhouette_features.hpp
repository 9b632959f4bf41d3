// SPDX-License-Identifier: Apache-2.0
// What a silhouette says at a glance: how much it moves, how far it is spread.
#pragma once

#include <deque>

#include <opencv2/core/mat.hpp>

namespace choreo::body {

/// Contraction index: the silhouette's share of its bounding box, in (0, 1]; high when the limbs are drawn in.
/// @source Camurri, Lagerlof, Volpe 2003, "Recognizing emotion from dance movement".
[[nodiscard]] double contraction(int area_px, cv::Size box);

/// Quantity of motion: the area that the silhouette covered within the last `window_s` seconds and covers no more,
/// over its area now. At rest 0; of a window in seconds, so that the frame rate does not matter much.
/// @source Camurri, Lagerlof, Volpe 2003 (silhouette motion images).
class MotionMeter {
 public:
  /// @param window_s  seconds, > 0.
  explicit MotionMeter(double window_s) : window_s_(window_s) {}

  /// @param mask  CV_8UC1, 0 or 255, not empty, kept by reference: must not be changed afterwards.
  /// @param time_s  seconds, increasing.
  /// @return 0 or more.
  [[nodiscard]] double add(const cv::Mat& mask, int area_px, double time_s);

  /// Forgets what was; after a frame without a body.
  void reset() { past_.clear(); }

 private:
  struct Past {
    cv::Mat mask;
    double time_s;
  };
  double window_s_;
  std::deque<Past> past_;
};

}  // namespace choreo::body
