// SPDX-License-Identifier: Apache-2.0
#include "cli/recording.hpp"

namespace choreo::cli {

void RecordStage::process(pipeline::Observation& observation) {
  const auto time_s = to_seconds(observation.time);
  outputs::FrameRow row;
  row.frame = observation.frame->sequence + 1;
  row.time_s = time_s;
  row.body = observation.state != nullptr;
  if (row.body) {
    const auto& state = *observation.state;
    row.area_px = state.area();
    row.centroid_px = state.centroid();
    row.box_px = state.box() + state.center();
    row.quantity_of_motion = observation.quantity_of_motion;
    row.contraction = observation.contraction;
    ++bodies_;
    body_pixels_ += observation.mask.area;
    inferred_pixels_ += observation.mask.inferred;
    if (observation.mask.cut) ++cut_bodies_;
    thumbnails_.add(observation.picture, observation.mask.mask, state, time_s);
  }
  if (observation.mask.sudden) sudden_changes_s_.push_back(time_s);
  if (masks_ != nullptr) masks_->add(observation.mask.mask);
  rows_.push_back(row);
  states_.push_back(std::move(observation.state));
  seen_(observation.time);
}

}  // namespace choreo::cli
