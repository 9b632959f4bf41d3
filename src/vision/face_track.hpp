// SPDX-License-Identifier: Apache-2.0
// From what a detector finds now and then to one face that is followed.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "vision/face.hpp"
#include "vision/face_detector.hpp"

namespace choreo::vision {

/// Which of several faces is the performer's.
enum class FaceChoice {
  kTracked,  ///< The one that was there first, as long as it is seen.
  kLargest,  ///< The largest: who stands nearest.
};

struct FaceTrackOptions {
  FaceChoice choose = FaceChoice::kTracked;
  int persistence = 3;   ///< Times that a face is seen before it counts, [1, 100].
  double coast_s = 1.0;  ///< How long a face is kept that is not seen, [0, 60].
  double hidden_s = 10;  ///< The same where the body is still where the face was: an arm before it. [0, 600].

  void validate() const;  ///< @throws Error (usage) naming the option, its value and its range.
};

/// One search of a detection picture; all lengths in its pixels.
struct FaceQuery {
  cv::Rect where;
  double least_px = 0, most_px = 0;  ///< Width of a face, cheek to cheek.
  FaceLook look = FaceLook::kFront;
};

/// What a search found.
struct FaceSighting {
  FaceQuery query;
  double time_s = 0;        ///< Of the picture that was searched.
  std::vector<Face> faces;  ///< Best first.
  /// CV_8UC1, the body mask of that picture, of any size; empty where nothing is known of the body.
  cv::Mat body;
};

/// What a frame knows of faces.
struct FaceReport {
  std::optional<TrackedFace> face;  ///< In pixels of the detection picture.
  int in_sight = 0;  ///< Faces that count, those on the wall left out as far as they are known to be there.
};

/// Where a face is, or may be, for whoever searches next.
struct FaceCandidate {
  std::uint64_t id = 0;
  cv::Point2d centre;
  double width = 0;
  double unseen_s = 0;
  int misses = 0;          ///< Searches over it, since it was last found.
  bool confirmed = false;  ///< Seen often enough to count.
  bool chosen = false;
};

/// Follows faces; one of them is the performer's.
///
/// A face counts once it was seen `persistence` times. Between searches it moves on with damped velocity; unseen, it
/// stays for `coast_s` while its confidence falls. Where the frame's body mask is known, the performer's face is on the
/// body, and one whose place the body goes on covering is hidden rather than gone: it stays for `hidden_s`, or until
/// another is seen on the body. Where it is not, a face that has never moved, such as a poster's, does not follow one
/// that was lost elsewhere unless it came up after that; and it gives way to a face that moves. The same sightings and
/// times give the same results, to the last bit.
/// @thread thread-bound
class FaceTracker {
 public:
  explicit FaceTracker(const FaceTrackOptions& options);

  /// @param time_s  of the frame; seconds, increasing.
  /// @param size  of detection pictures.
  /// @param sighting  what takes effect at this frame; null: nothing.
  [[nodiscard]] FaceReport update(double time_s, cv::Size size, const FaceSighting* sighting);

  /// As of the last update: the chosen one first, then by age.
  [[nodiscard]] std::vector<FaceCandidate> candidates() const;

 private:
  struct Track {
    std::uint64_t id = 0;
    cv::Point2d first, centre, velocity;  // px, px, px/s
    double width = 0;
    double confidence = 0;
    double first_s = 0, seen_s = 0;
    double on_body = -1;  // Share of the face on the body, followed; -1 where nothing was known.
    int hits = 0;
    int misses = 0;
    bool moved = false;
    bool covered = false;  // At the last search the body was where the face, unseen, should have been.

    [[nodiscard]] cv::Point2d at(double time_s) const;
  };

  void match(const FaceSighting& sighting, cv::Size size);
  void forget(double time_s, cv::Size size);
  void choose(double time_s);
  [[nodiscard]] bool counts(const Track& track) const;
  [[nodiscard]] bool may_be_chosen(const Track& track) const;
  [[nodiscard]] double stays_s(const Track& track) const;

  FaceTrackOptions options_;
  std::vector<Track> tracks_;  // By id.
  std::uint64_t next_id_ = 1;
  std::uint64_t chosen_ = 0;  // 0: none.
  double time_s_ = 0;
  // Of the face that was lost last.
  std::optional<double> lost_s_;
  cv::Point2d lost_at_;
  double lost_width_ = 0;
};

}  // namespace choreo::vision
