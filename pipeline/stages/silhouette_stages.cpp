// SPDX-License-Identifier: Apache-2.0
#include "pipeline/stages/silhouette_stages.hpp"

#include "pipeline/person_evidence.hpp"
#include "pipeline/working_size.hpp"

namespace choreo::pipeline {

void PictureStage::process(Observation& observation) {
  observation.picture = at_working_size(observation.frame->bgr, size_);
  if (with_depth_) observation.depth_mm = depth_at_working_size(observation.frame->depth, size_);
}

void MaskStage::process(Observation& o) {
  vision::PersonEvidence person;
  if (segmenter_.wants_person()) person = evidence_of(o, o.picture.size(), others_);
  o.mask = segmenter_.process(o.picture, o.depth_mm, to_seconds(o.time), person);
}

void StateStage::process(Observation& observation) {
  const auto& mask = observation.mask;
  if (!mask.body) {
    motion_.reset();
    return;
  }
  auto state = std::make_unique<const body::MaskState>(mask.mask);
  observation.contraction = body::contraction(mask.area, state->box().size());
  observation.quantity_of_motion = motion_.add(mask.mask, mask.area, to_seconds(observation.time));
  observation.state = std::move(state);
}

}  // namespace choreo::pipeline
