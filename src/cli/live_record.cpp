// SPDX-License-Identifier: Apache-2.0
#include "cli/live_record.hpp"

namespace choreo::cli {

void LiveRecordStage::process(pipeline::Observation& observation) {
  // The history forgets by time and by number: as many rows as it still has are kept.
  rows_.push_back(row_of(observation));
  rows_.back().zstar_tt = observation.zstar_row.back();
  cut_.push_back(observation.mask.cut);
  inferred_.add(observation.mask);
  if (rows_.back().body) {
    ++bodies_;
    if (cut_.back()) ++cut_bodies_;
    thumbnails_.add(observation.picture, observation.mask.mask, *observation.state, rows_.back().time_s);
  }
  forget(rows_.size() - observation.z_row.size());
  constexpr std::size_t kMostChanges = 1000;
  if (observation.mask.sudden) sudden_changes_s_.push_back(rows_.back().time_s);
  if (sudden_changes_s_.size() > kMostChanges) sudden_changes_s_.pop_front();
  if (show_) show_(observation);
}

void LiveRecordStage::forget(std::size_t count) {
  for (; count > 0; --count) {
    if (rows_.front().body) {
      --bodies_;
      if (cut_.front()) --cut_bodies_;
    }
    rows_.pop_front();
    cut_.pop_front();
  }
}

}  // namespace choreo::cli
