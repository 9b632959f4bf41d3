// SPDX-License-Identifier: Apache-2.0
#include "cli/live_record.hpp"

#include <algorithm>

namespace choreo::cli {

void LiveRecordStage::process(pipeline::Observation& observation) {
  // The history forgets by time and by number: as many rows as it still has are kept.
  rows_.push_back(row_of(observation));
  rows_.back().zstar_tt = observation.zstar_row.back();
  cut_.push_back(rows_.back().body && observation.mask.cut);
  if (keeps_particles_) particles_.push_back(observation.particles);
  tally_.add(observation.mask, to_seconds(observation.time));
  if (rows_.back().body) {
    thumbnails_.add(observation.picture, observation.mask.mask, *observation.state, rows_.back().time_s);
  }
  const auto old = static_cast<std::ptrdiff_t>(rows_.size() - observation.z_row.size());
  rows_.erase(rows_.begin(), rows_.begin() + old);
  cut_.erase(cut_.begin(), cut_.begin() + old);
  if (keeps_particles_) particles_.erase(particles_.begin(), particles_.begin() + old);
  constexpr std::size_t kMostChanges = 1000;
  if (observation.mask.sudden) sudden_changes_s_.push_back(rows_.back().time_s);
  if (sudden_changes_s_.size() > kMostChanges) sudden_changes_s_.pop_front();
  if (show_) show_(observation);
}

std::size_t LiveRecordStage::bodies() const {
  return std::size_t(std::count_if(rows_.begin(), rows_.end(), [](const auto& row) { return row.body; }));
}

std::size_t LiveRecordStage::cut_bodies() const { return std::size_t(std::count(cut_.begin(), cut_.end(), true)); }

}  // namespace choreo::cli
