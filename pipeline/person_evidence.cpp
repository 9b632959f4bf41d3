// SPDX-License-Identifier: Apache-2.0
#include "pipeline/person_evidence.hpp"

#include <algorithm>

namespace choreo::pipeline {

vision::PersonEvidence evidence_of(const vision::PersonLook& look, cv::Size size) {
  constexpr double kBlur = 2.5;  // Pixels of the network's silhouette, whose edges are so soft.
  return {vision::silhouette_in_picture(look, size), kBlur * look.region.side / std::max(1, look.silhouette.cols)};
}

vision::PersonEvidence evidence_of(const PersonSighting& sighting, cv::Size size, Nanoseconds now) {
  constexpr double kFastest = 2.0;  // Sides of the region a second; faster is a joint that was mistaken.
  auto evidence = evidence_of(sighting.look, size);
  const double side = sighting.look.region.side;
  const double speed = std::min(sighting.speed.value_or(side), kFastest * side);
  evidence.doubt_px += speed * to_seconds(std::max(now - sighting.time, Nanoseconds{0}));
  return evidence;
}

}  // namespace choreo::pipeline
