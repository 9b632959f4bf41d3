// SPDX-License-Identifier: Apache-2.0
// Finds the performer's face beside the frames' own way.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "pipeline/face_pattern.hpp"
#include "pipeline/followed_face.hpp"
#include "pipeline/search_beside.hpp"
#include "pipeline/stage.hpp"
#include "vision/face_detector.hpp"
#include "vision/face_search.hpp"
#include "vision/face_track.hpp"

namespace choreo::pipeline {

struct FaceStageOptions {
  vision::FaceSearchOptions search;
  vision::FaceTrackOptions track;
  int delay_frames = 3;  ///< Frames from the one that is searched to the one that knows, [1, 60].
  int rows = 480;        ///< Rows of the picture that is searched, [60, 4320]; larger ones are reduced to so many.
  bool waits = true;     ///< For a detection that is not ready when it is due; else it is void.
  /// Told of every detection that was not ready: the sequence number of the frame at which it was due. Called by the
  /// thread that calls `process`.
  std::function<void(std::uint64_t)> on_late = {};

  void validate() const;  ///< @throws Error (usage) naming the option, its value and its range.
};

/// frame, mask, person -> face, number of faces.
///
/// Where the person network sees the performer's face it is that one, followed from the frame that was looked at to
/// this one, and where it sees the back of the head there is none: no detector searches. Elsewhere one does:
///
/// A search that is asked for at one frame is done by a thread of the stage's own and takes effect exactly
/// `delay_frames` frames later, or never. So the results depend on the frames and on which searches were late, and on
/// nothing else: frames whose run noted a late one (Frame::late_face) void it again, however fast the search is now.
/// Comes after MaskStage, or without one; it then knows nothing of the body. A frame without a picture has no face.
/// An error of the detector ends the run at the frame at which its result was due. A search takes one core, which
/// needs a CoreLimit: the others are the frames'.
class FaceStage final : public Stage {
 public:
  FaceStage(std::unique_ptr<vision::FaceDetector> detector, FaceStageOptions options);

  [[nodiscard]] std::string name() const override { return "face"; }
  void process(Observation& observation) override;

  [[nodiscard]] std::uint64_t asked() const { return beside_.asked(); }  ///< Searches so far.
  [[nodiscard]] std::uint64_t late() const { return beside_.late(); }    ///< Of these, void.

 private:
  struct Search {
    vision::FaceSighting sighting;
    devices::FramePtr frame;
  };
  [[nodiscard]] std::shared_ptr<const Search> due(const Observation& observation);
  void follow(vision::TrackedFace& face, cv::Size size, const Search* search, const Observation& observation);
  void ask(const Observation& observation, cv::Size size, const vision::FaceQuery& query);

  FaceStageOptions options_;
  std::unique_ptr<vision::FaceDetector> detector_;  // The searches'.
  vision::FaceSearch search_;
  vision::FaceTracker tracker_;
  FollowedFace followed_;  // The network's.
  std::int64_t frames_ = 0;
  std::optional<FacePattern> pattern_;            // Of the detector's, as it last found it.
  std::uint64_t chosen_ = 0;                      // Whose it is; 0: nobody's.
  cv::Point2d last_;                              // Its place at the frame before.
  std::deque<std::shared_ptr<Search>> searches_;  // Asked for, and not due yet.
  SearchBeside beside_;                           // Last: its thread uses what is above.
};

}  // namespace choreo::pipeline
