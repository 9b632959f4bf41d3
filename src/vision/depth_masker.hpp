// SPDX-License-Identifier: Apache-2.0
// From a depth picture to what stands before the room, frame after frame.
#pragma once

#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "vision/body_masker.hpp"
#include "vision/depth_background.hpp"

namespace choreo::vision {

/// How a depth picture becomes a body mask.
struct DepthOptions {
  std::optional<double> threshold_mm;  ///< Nearer than the room by more is body, (0, 5000]; absent: by the spread.
  double spread_factor = 4.0;          ///< Threshold over the spread of the readings where it is measured, [1, 20].
  double least_threshold_mm = 25.0;    ///< The measured threshold is never lower, [1, 1000].
  double near_mm = 0;                  ///< What is nearer to the camera is no body, [0, 20000].
  double far_mm = 0;                   ///< What is farther is no body, [0, 20000]; 0: no such plane.

  void validate() const;  ///< @throws Error (usage) naming the option, its value and its range.
  [[nodiscard]] DepthMargin margin() const;
};

/// What one depth picture tells.
struct DepthMask {
  cv::Mat body;           ///< CV_8UC1, 255 where there is body; small parts are still among it.
  cv::Mat known;          ///< CV_8UC1, 255 where depth decided.
  cv::Mat inferred;       ///< CV_8UC1, 255 where the room behind is inferred; may be empty.
  bool sudden = false;    ///< Most of the room is at another depth: the camera moved. It is learned anew.
  bool learning = false;  ///< No mask: the room is being learned anew.
};

/// Makes body masks against a room whose depth it follows.
///
/// Body is what is nearer than the room by more than the margin, between the planes. Before a room of unknown depth it
/// is what lies between the planes, where there is a far plane; else what goes on from certain body. A pixel is then
/// what most of its 3 x 3 are; without a reading it counts as no body, so that dropouts in a body are filled and the
/// projector's shadow beside it is not. Gaps are closed (mask.steps) and holes of less than a thousandth of the picture
/// filled.
///
/// Readings beyond the room, or where nothing was known of it, are the room once there are three in a row over at least
/// 0.15 s, without a gap of more than 0.25 s (or a frame) between them: a body is only nearer. The nearer depth is
/// remembered for a minute: a door that closes is the room again, not a body, once for three frames and 0.15 s nineteen
/// twentieths of its surface have been within the margin of that depth and at most a tenth of what it had uncovered
/// still showed. So whoever stands still in the doorway stays body, at the door's own depth too; and so does a curtain
/// that is closed only in part.
///
/// Elsewhere the room follows slow drift outside the body (background.follow_s). The same pictures and times give the
/// same masks, to the last bit.
/// @thread thread-bound
class DepthMasker {
 public:
  /// @param mask  steps, roi, ignore, follow_s, sudden_percent and relearn_s are used.
  DepthMasker(DepthBackground room, DepthOptions options, MaskOptions mask);

  /// @param depth_mm  CV_16UC1 of the room's size, 0 where nothing is known.  @param time_s  seconds, increasing.
  [[nodiscard]] DepthMask process(const cv::Mat& depth_mm, double time_s);

 private:
  // For how long something has been seen at each pixel.
  class Lasting {
   public:
    void begin(cv::Size size);
    // Counts a reading that shows it; whether that has lasted. A longer gap before it starts anew.
    bool saw(cv::Point p, double time_s, double longest_gap_s);
    void forget(cv::Point p);

   private:
    cv::Mat readings_;  // CV_8UC1, as many as are needed at most.
    cv::Mat since_s_;   // CV_64FC1, the first of them,
    cv::Mat last_s_;    // and the last.
  };

  void begin(DepthBackground room);
  [[nodiscard]] cv::Mat standing_before(const cv::Mat& depth_mm) const;
  [[nodiscard]] double moved_percent(const cv::Mat& depth_mm) const;
  void follow(const cv::Mat& depth_mm, const cv::Mat& body, double time_s, double dt_s);
  void remember(cv::Point p, double time_s);
  void take_back(const cv::Mat& depth_mm, const cv::Mat& body, double time_s, double dt_s);
  bool relearn(const cv::Mat& depth_mm, double time_s);

  DepthOptions options_;
  MaskOptions mask_options_;
  DepthMargin margin_;
  DepthBackground room_;
  cv::Mat running_mm_;                        // CV_32FC1, the room's depth with what is below a millimetre.
  Lasting beyond_;                            // Readings beyond the room.
  cv::Mat old_mm_;                            // CV_32FC1, the nearer depth that readings beyond replaced; 0: none.
  cv::Mat old_spread_mm_;                     // CV_32FC1, its spread.
  cv::Mat old_until_s_;                       // CV_64FC1, until when it is remembered,
  std::optional<double> remembered_until_s_;  // and the last of these.
  Lasting back_;                              // Pictures in which what is remembered is back.
  cv::Mat allowed_;                           // See allowed_area.
  std::optional<double> last_time_s_;
  std::optional<double> learning_since_s_;
  std::vector<cv::Mat> learning_;
};

}  // namespace choreo::vision
