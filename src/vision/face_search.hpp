// SPDX-License-Identifier: Apache-2.0
// Where and when to look for faces, so that it costs little.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <opencv2/core/types.hpp>

#include "vision/face_track.hpp"

namespace choreo::vision {

struct FaceSearchOptions {
  double least_share = 0.04;  ///< Narrowest face, cheek to cheek, of the picture's height, [0.01, 0.5].
  double most_share = 0.8;    ///< Widest, (least_share, 1].
  int near_frames = 5;        ///< Frames between two looks at a face that is followed, [1, 1000].
  int whole_frames = 30;      ///< Frames in which the whole is searched for a band of sizes beside it, [1, 100000].
  int lost_frames = 3;        ///< Frames between two steps while nobody's face is known, [1, 1000].

  void validate() const;  ///< @throws Error (usage) naming the option, its value and its range.
};

/// Decides for every frame whether to search, where and for what.
///
/// Near a known face for faces of its width, in turns with near a face that does not count yet; over the whole picture
/// in steps, each a part of the picture and a band of sizes, the large ones first; beside a known face the parts are
/// small, so that a search ends before the next frame comes. Rounds over the whole picture change the look: front,
/// front, brightened, front, front, profile.
/// It counts frames and reads no clock.
/// @thread thread-bound
class FaceSearch {
 public:
  explicit FaceSearch(const FaceSearchOptions& options);

  /// Called once for every frame. Nothing: no search is needed at this frame.
  /// @param size  of the detection picture, the same for every frame that has one.
  /// @param candidates  of FaceTracker.
  /// @param body  where the body is, as far as that is known; empty: unknown. Searches of the whole picture are then
  ///   of this part.
  [[nodiscard]] std::optional<FaceQuery> next(cv::Size size, const std::vector<FaceCandidate>& candidates,
                                              const cv::Rect& body = {});

 private:
  [[nodiscard]] FaceQuery near(const FaceCandidate& candidate, cv::Size size) const;
  [[nodiscard]] std::optional<FaceQuery> step(cv::Size size, const cv::Rect& body, bool known);

  FaceSearchOptions options_;
  std::uint64_t frames_ = 0;
  std::uint64_t near_count_ = 0;
  std::uint64_t last_near_ = 0, last_step_ = 0;  // Frame numbers, from 1.
  int band_ = -1, part_ = 0;                     // To be searched next; no band: a round begins.
  int parts_ = 1;                                // Of the band that was searched last.
  std::uint64_t round_ = 0;
};

}  // namespace choreo::vision
