// SPDX-License-Identifier: Apache-2.0
// From a frame's picture, its depth or both to the body's silhouette.
#pragma once

#include <deque>
#include <optional>
#include <string_view>
#include <utility>

#include <opencv2/core/mat.hpp>

#include "vision/body_masker.hpp"
#include "vision/camera_motion.hpp"
#include "vision/depth_masker.hpp"
#include "vision/person_masker.hpp"

namespace choreo::vision {

/// What decides which pixels are body.
enum class Segmentation { kColour, kDepth, kBoth, kPerson, kAuto };

/// @param name  "colour", "depth", "both", "person" or "auto" (asserted).
[[nodiscard]] Segmentation segmentation_named(std::string_view name);

/// One mask of two: depth decides where it is known, colour where it is not and along the edges.
///
/// Depth's edges are ragged. Within `edge_px` of the border of the depth mask colour decides, where within 4 `edge_px`
/// the two agree on at least 0.9 of what is body by depth beside that band, and on as much of what is not: clothes like
/// the wall, or a shadow on it, are no help.
/// @param by_colour, by_depth, known  CV_8UC1, 0 or 255, of one size; `known` is where depth decided.
[[nodiscard]] cv::Mat combined(const cv::Mat& by_colour, const cv::Mat& by_depth, const cv::Mat& known, int edge_px);

/// Makes body masks by colour, by depth, by both, of a person, or as it turns out: whatever differs is body until a
/// person was seen for a third of a second, and what stands still meanwhile becomes background; from then on the person
/// is.
/// @thread thread-bound
class Segmenter {
 public:
  /// By colour alone: what `colour` gives, to the last bit.
  Segmenter(BodyMasker colour);  // NOLINT(google-explicit-constructor): such a masker is a segmenter.

  /// Of a person: what `person` gives, to the last bit.
  Segmenter(PersonMasker person);  // NOLINT(google-explicit-constructor): likewise.

  /// As it turns out.
  /// @param somebody  whether a person was seen while the background was learned.
  Segmenter(const BackgroundEstimate& background, MaskOptions options, bool somebody);

  /// By depth alone, or, with `colour`, by both.
  Segmenter(std::optional<BodyMasker> colour, DepthMasker depth, MaskOptions options);

  /// @param picture   CV_8UC3; not looked at where depth alone decides.
  /// @param depth_mm  CV_16UC1 of the picture's size. Empty where a frame has none: there is no body by depth then, and
  ///   by both colour decides alone. Not looked at where colour alone decides.
  /// @param time_s    seconds, increasing.
  /// @param person    looked at where `wants_person`.
  [[nodiscard]] MaskResult process(const cv::Mat& picture, const cv::Mat& depth_mm, double time_s,
                                   const PersonEvidence& person = {});

  /// Of a camera that shakes every picture is brought to where it was when it took the plate, and its mask back; where
  /// too little of the room is found again the network's silhouette stands alone, or there is no body, and after a
  /// second the camera counts as one that may move. Of such a one the silhouette stands alone wherever it does, or
  /// there is no body. Of pictures alone, not of depth.
  /// @param background  its plate, camera and never_seen are used.
  void follow_camera(const BackgroundEstimate& background);

  [[nodiscard]] bool uses_depth() const { return depth_.has_value(); }
  [[nodiscard]] bool wants_person() const { return person_.has_value() || as_it_turns_out_; }
  /// Of a person, by now.
  [[nodiscard]] bool of_person() const { return person_.has_value(); }
  [[nodiscard]] std::optional<double> threshold() const;  ///< Grey levels of D; nothing by depth alone.

 private:
  [[nodiscard]] MaskResult of_steady(const cv::Mat& picture, const cv::Mat& depth_mm, double time_s,
                                     const PersonEvidence& person);
  [[nodiscard]] MaskResult of_shaken(const cv::Mat& picture, const cv::Mat& depth_mm, double time_s,
                                     const PersonEvidence& person);
  [[nodiscard]] MaskResult of_watched(const cv::Mat& picture, const cv::Mat& depth_mm, double time_s,
                                      const PersonEvidence& person);
  void watch(const cv::Mat& picture, const PersonEvidence& person);
  void meet(const PersonEvidence& person, const cv::Mat& differs, double time_s);
  [[nodiscard]] MaskResult finished(cv::Mat mask, const DepthMask& depth) const;

  std::optional<BodyMasker> colour_;
  std::optional<DepthMasker> depth_;
  std::optional<PersonMasker> person_;
  MaskOptions options_;
  struct Camera {
    CameraKind kind;
    cv::Mat plate;        // Of a camera that may move the picture after its last move, reduced.
    CameraMotion motion;  // Since then.
    std::deque<std::pair<double, CameraShift>> shifts;  // Of the last frames, by their times in seconds.
    std::optional<double> lost_since_s;
  };
  std::optional<Camera> camera_;
  bool as_it_turns_out_ = false;
  double noise_ = 0;
  std::optional<double> there_since_s_;  // A person, without a break.
};

}  // namespace choreo::vision
