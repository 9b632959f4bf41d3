// SPDX-License-Identifier: Apache-2.0
#include "pipeline/followed_face.hpp"

#include <algorithm>
#include <cmath>

namespace choreo::pipeline {

FollowedFace::Seen FollowedFace::look(const vision::Face& face, const Observation& observation) const {
  const auto& sighting = *observation.person;
  Seen now;
  now.face.centre = now.last = (face.box.tl() + face.box.br()) / 2;
  now.face.width = face.box.width;
  now.face.confidence = face.confidence;
  now.time = now.first = sighting.time;
  if (!seen_) return now;
  constexpr double kApart_s = 0.5;  // Of a look so long ago nothing is known of the way between.
  const double dt = to_seconds(now.time - seen_->time);
  if (dt > 0 && dt <= kApart_s) now.velocity = (now.face.centre - seen_->face.centre) / dt;
  now.first = seen_->first;
  now.looks = seen_->looks + 1;
  now.last = seen_->last;
  return now;
}

std::optional<vision::TrackedFace> FollowedFace::update(const Observation& observation) {
  const auto face = observation.person ? vision::face_of(observation.person->look) : std::nullopt;
  knows_ = face || (observation.person && observation.person->look.faces_away());
  // An arm before the eyes hides a face for a moment, and a machine that is busy looks late.
  constexpr double kCoasts_s = 0.5;
  constexpr int kLooks = 2;
  const auto age_s = [&](Nanoseconds time) { return to_seconds(observation.time - time); };
  if (face && age_s(observation.person->time) <= 2 * kCoasts_s) {
    if (!seen_ || seen_->time != observation.person->time) seen_ = look(*face, observation);
  } else if (!seen_ || seen_->looks < kLooks || !observation.person || observation.person->look.faces_away() ||
             age_s(seen_->time) > kCoasts_s) {
    knows_ = knows_ && !face;
    seen_.reset();
    return std::nullopt;
  }
  knows_ = true;
  if (seen_->looks < kLooks) return std::nullopt;
  constexpr double kDamping_s = 0.15;
  auto now = seen_->face;
  now.unseen_s = to_seconds(std::max(observation.time - seen_->time, Nanoseconds{0}));
  now.confidence *= 1 - 0.5 * std::min(1.0, now.unseen_s / (2 * kCoasts_s));
  now.age_s = to_seconds(observation.time - seen_->first);
  now.centre += seen_->velocity * (kDamping_s * (1 - std::exp(-now.unseen_s / kDamping_s)));
  const auto& looked_at = observation.person->frame;
  if (!seen_->pattern && seen_->time == observation.person->time && looked_at && looked_at != observation.frame) {
    const auto& picture = observation.picture.empty() ? observation.frame->bgr : observation.picture;
    seen_->pattern.emplace(looked_at->bgr, picture.size(), seen_->face.centre, seen_->face.width);
  }
  if (seen_->pattern) {
    const auto found = seen_->pattern->find(observation.frame->bgr, {seen_->face.centre, now.centre, seen_->last});
    now.centre = found.value_or(now.centre);
  }
  seen_->last = now.centre;
  return now;
}

}  // namespace choreo::pipeline
