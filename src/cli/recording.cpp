// SPDX-License-Identifier: Apache-2.0
#include "cli/recording.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace choreo::cli {

outputs::FrameRow row_of(const pipeline::Observation& observation) {
  outputs::FrameRow row;
  row.frame = observation.frame->sequence + 1;
  row.time_s = to_seconds(observation.time);
  row.body = observation.state != nullptr;
  if (row.body) {
    const auto& state = *observation.state;
    row.area_px = state.area();
    row.centroid_px = state.centroid();
    row.box_px = state.box() + state.center();
    row.quantity_of_motion = observation.quantity_of_motion;
    row.contraction = observation.contraction;
  }
  return row;
}

outputs::ParticleRow particle_row_of(const pipeline::Observation& o) {
  return {o.frame->sequence + 1, to_seconds(o.time), o.face, o.arms, o.particles};
}

void MaskTally::tell(Summary& summary) const {
  summary.inferred = body_ > 0 ? inferred_ / body_ : 0.0;
  summary.camera_moved = frames_ > 0 ? moved_ / frames_ : 0.0;
  if (summary.body.empty() || !of_person_from_s_) return;
  summary.body = "the person whom the network sees";
  if (*of_person_from_s_ > 0) {
    summary.body += fmt::format(", from {:.2f} s on; before, whatever differs from the background", *of_person_from_s_);
  }
}

void RecordStage::process(pipeline::Observation& observation) {
  const auto row = row_of(observation);
  seen_(observation);
  tally_.add(observation.mask, to_seconds(observation.time));
  if (row.body) thumbnails_.add(observation.picture, observation.mask.mask, *observation.state, row.time_s);
  if (observation.mask.sudden) sudden_changes_s_.push_back(row.time_s);
  if (seen_frames_++ % step_ == 0) {
    if (rows_.size() == most_rows_) thin_out();
    if ((seen_frames_ - 1) % step_ == 0) {
      if (masks_ != nullptr) masks_->add(observation.mask.mask);
      rows_.push_back(row);
      cut_.push_back(row.body && observation.mask.cut);
      if (keeps_particle_rows_) particle_rows_.push_back(particle_row_of(observation));
      states_.add(observation);
    }
  }
}

void RecordStage::thin_out() {
  keep_every_second(rows_);
  keep_every_second(cut_);
  keep_every_second(particle_rows_);
  states_.keep_every_second();
  if (masks_ != nullptr) masks_->keep_every_second();
  step_ *= 2;
}

std::size_t RecordStage::bodies() const {
  return std::size_t(std::count_if(rows_.begin(), rows_.end(), [](const auto& row) { return row.body; }));
}

std::size_t RecordStage::cut_bodies() const { return std::size_t(std::count(cut_.begin(), cut_.end(), true)); }

}  // namespace choreo::cli
