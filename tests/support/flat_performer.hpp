// SPDX-License-Identifier: Apache-2.0
// A second drawn performer, a flat cartoon in another room: a judge of masks that shares nothing with the synthetic
// one.
#pragma once

#include <string>

#include <opencv2/core.hpp>

namespace choreo::test {

struct FlatScene {
  int look = 0;  ///< 0: T-shirt and trousers; 1: dress with wide sleeves; 2: wall-coloured jacket, flags.
  std::string script = "dance";  ///< "dance", "wave" (the arms only), "stand" (breathing by a pixel) or "signal".
  std::string text = {};         ///< Letters A to Z that "signal" holds for 1.5 s each, after a second on the way.
  double bend = 0;               ///< Degrees by which the elbows of raised arms are bent then, either way in turns.
  double empty_s = 1;            ///< Seconds of empty room, then 3 s of walking in from the left; 0: there throughout.
  double chair_at_s = -1;        ///< From when one more chair stands at the right, beyond reach; below 0: never.
  cv::Size size{640, 480};
  unsigned seed = 1;  ///< Of the noise, the wall's colour (one of three) and the dance's tempo and phases.
};

struct FlatFrame {
  cv::Mat picture;  ///< CV_8UC3, blue green red.
  cv::Mat body;     ///< CV_8UC1, 255 where what is seen of body, clothes and hair covers at least half of the pixel.
  cv::Mat held;     ///< CV_8UC1, 255 where what is seen of flags and their sticks does.
};

/// Seconds until the last letter of a text has been held and the arms hang again.
[[nodiscard]] double seconds_of_text(const std::string& text);

/// Films a scene. A frame depends on scene and time (to the microsecond) alone.
/// @cost a frame of 640x480 about 40 ms.
/// @thread reentrant; one object may be used by several threads.
class FlatPerformer {
 public:
  /// @throws std::invalid_argument for an unknown look or script.
  explicit FlatPerformer(FlatScene scene);

  /// @param time_s  from the first frame, not negative.
  [[nodiscard]] FlatFrame frame(double time_s) const;

 private:
  FlatScene scene_;
  cv::Mat room_, room_with_chair_;  // CV_8UC3, four times as large as the picture.
  cv::Mat light_;                   // CV_32FC3, factors, as large as the picture.
};

}  // namespace choreo::test
