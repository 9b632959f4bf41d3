// SPDX-License-Identifier: Apache-2.0
// From a picture to the body's silhouette, frame after frame.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "vision/background_estimate.hpp"
#include "vision/tone_curve.hpp"

namespace choreo::vision {

/// A rectangle in fractions of the picture, so that it fits any size: 0 <= x0 < x1 <= 1, likewise y.
struct Zone {
  double x0 = 0, y0 = 0, x1 = 1, y1 = 1;
  [[nodiscard]] bool valid() const { return 0 <= x0 && x0 < x1 && x1 <= 1 && 0 <= y0 && y0 < y1 && y1 <= 1; }
  friend bool operator==(const Zone&, const Zone&) = default;
};

/// How a picture becomes a body mask.
struct MaskOptions {
  std::optional<double> threshold;  ///< Grey levels of D, (0, 255]; absent: from the measured noise.
  double noise_factor = 4.0;        ///< Threshold over noise where it is measured, [1, 20].
  double least_threshold = 10.0;    ///< Grey levels, [1, 255]; the measured threshold is never lower.
  int steps = 1;                    ///< Grow steps, then as many shrink steps, [0, 32].
  bool half_contrast_edge = true;   ///< Take back halos and edge pixels that are more wall than body.
  bool drop_soft_light = true;      ///< Take away soft shadows and glows.
  bool largest_only = false;        ///< Keep the largest component alone.
  double speck_percent = 0.02;      ///< Components smaller than this share of the picture go, [0, 100].
  double min_body_percent = 0.5;    ///< Of the picture; a smaller mask is no body, [0, 100].
  Zone roi;                         ///< What lies outside is no body.
  std::vector<Zone> ignore;         ///< What lies inside any of these is no body.

  bool follow_exposure = true;   ///< Bring the background to each picture's exposure, white balance and tone.
  double follow_s = 20.0;        ///< Time constant of the running background outside the body, s, [0, 3600]; 0: off.
  double sudden_percent = 60.0;  ///< A change of more than this share of the picture is not a body, [1, 100]; 100: off.
  double absorb_s = 0;           ///< What stands still for so long becomes background, s, [0, 3600]; 0: nothing does.
  double relearn_s = 1.0;        ///< How long the background is learned anew after a sudden change, s, [0, 60].

  void validate() const;  ///< @throws Error (usage) naming the option, its value and its range.
};

/// CV_8UC1, 255 where a body may be by `roi` and `ignore`; empty: everywhere.
[[nodiscard]] cv::Mat allowed_area(const MaskOptions& options, cv::Size size);

/// What one picture gave.
struct MaskResult {
  cv::Mat mask;           ///< CV_8UC1, 0 or 255; all 0 where there is no body.
  int area = 0;           ///< Pixels in `mask`.
  int inferred = 0;       ///< Of them, those before what was never seen, which something else than the picture decided.
  bool body = false;      ///< Whether there is a body.
  bool cut = false;       ///< The body touches the picture's border.
  bool sudden = false;    ///< The whole picture changed at this frame; the background is learned anew.
  bool learning = false;  ///< No mask: the background is being learned anew.
  bool of_person = false;  ///< Body is the person whom the network sees, and not whatever differs from the background.
  bool camera_moved = false;  ///< The room told nothing: the mask is the network's, or none.
};

/// Makes body masks against a background that it follows through slow lighting.
///
/// The same pictures and times give the same masks, to the last bit.
/// @thread thread-bound
class BodyMasker {
 public:
  /// @param plate  CV_8UC3; every picture must be of its size (asserted).
  /// @param noise  standard deviation of the sensor's noise in D, grey levels.
  BodyMasker(const cv::Mat& plate, double noise, MaskOptions options);

  /// @param estimate  its plate, noise and dynamic are used, and not written to.
  BodyMasker(const BackgroundEstimate& estimate, MaskOptions options);

  /// @param picture  CV_8UC3.  @param time_s  seconds, increasing.
  [[nodiscard]] MaskResult process(const cv::Mat& picture, double time_s);

  [[nodiscard]] double threshold() const { return threshold_; }  ///< In use, grey levels of D.
  /// The background as it is now, CV_8UC3, in the plate's light; not to be written to.
  [[nodiscard]] const cv::Mat& background() const { return background_; }

 private:
  [[nodiscard]] double changed_percent(const cv::Mat& difference) const;
  void follow(const cv::Mat& picture, const cv::Mat& lit, double dt_s);
  void absorb(const cv::Mat& picture, const cv::Mat& mask, double time_s);
  bool relearn(const cv::Mat& picture, double time_s);

  MaskOptions options_;
  double threshold_;
  cv::Mat running_;     // CV_32FC3, the background in the light of the plate.
  cv::Mat background_;  // CV_8UC3, the same rounded.
  cv::Mat last_lit_;    // CV_8UC3, in the light of the last picture.
  cv::Mat last_mask_;   // CV_8UC1, the last body and what is near it; not to be learned from.
  DynamicBackground dynamic_;
  cv::Mat allowed_;  // CV_8UC1, where a body may be; empty: everywhere.
  std::optional<double> last_time_s_;
  unsigned turn_ = 0;    // Of the rows that are learned.
  cv::Mat still_;        // CV_8UC1, body that did not move since still_since_s_.
  cv::Mat still_looks_;  // CV_8UC3, what it looked like then.
  double still_since_s_ = 0;
  std::optional<double> learning_since_s_;
  std::vector<cv::Mat> learning_;
};

}  // namespace choreo::vision
