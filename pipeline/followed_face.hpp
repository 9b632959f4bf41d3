// SPDX-License-Identifier: Apache-2.0
// The face that the person network sees, where it is by now.
#pragma once

#include <optional>

#include "core/time.hpp"
#include "pipeline/face_pattern.hpp"
#include "pipeline/observation.hpp"
#include "vision/face.hpp"

namespace choreo::pipeline {

/// Follows the performer's face from the frame that was looked at to the frames until the next look.
///
/// Where it is not found (it turned, an arm is before it) the face moves on as it went between the last two looks, and
/// comes to rest. Two looks in a row must see it before it counts: one alone takes a back for a front now and then.
class FollowedFace {
 public:
  /// @return in pixels of the observation's picture; nothing where the last look saw no face.
  [[nodiscard]] std::optional<vision::TrackedFace> update(const Observation& observation);

  /// Whether the network's word on the face of the last update's frame is enough: it sees it, or sees it point away.
  [[nodiscard]] bool knows() const { return knows_; }

 private:
  struct Seen {
    vision::TrackedFace face;
    cv::Point2d velocity;                // px/s
    Nanoseconds time{0}, first{0};       // Of the look, and of the first of an unbroken row.
    int looks = 1;                       // In a row.
    std::optional<FacePattern> pattern;  // Nothing where the frames wait for looks.
    cv::Point2d last;                    // Where it was at the frame before.
  };

  [[nodiscard]] Seen look(const vision::Face& face, const Observation& observation) const;

  std::optional<Seen> seen_;
  bool knows_ = false;
};

}  // namespace choreo::pipeline
