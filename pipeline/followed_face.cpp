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
  if (sighting.frame && sighting.frame != observation.frame) {
    const auto& picture = observation.picture.empty() ? observation.frame->bgr : observation.picture;
    now.pattern.emplace(sighting.frame->bgr, picture.size(), now.face.centre, now.face.width);
  }
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
  if (!face) {
    seen_.reset();
    return std::nullopt;
  }
  if (!seen_ || seen_->time != observation.person->time) seen_ = look(*face, observation);
  constexpr int kLooks = 2;
  if (seen_->looks < kLooks) return std::nullopt;
  constexpr double kDamping_s = 0.15;
  auto now = seen_->face;
  now.unseen_s = to_seconds(std::max(observation.time - seen_->time, Nanoseconds{0}));
  now.age_s = to_seconds(observation.time - seen_->first);
  now.centre += seen_->velocity * (kDamping_s * (1 - std::exp(-now.unseen_s / kDamping_s)));
  if (seen_->pattern) {
    const auto found = seen_->pattern->find(observation.frame->bgr, {seen_->face.centre, now.centre, seen_->last});
    now.centre = found.value_or(now.centre);
  }
  seen_->last = now.centre;
  return now;
}

}  // namespace choreo::pipeline
