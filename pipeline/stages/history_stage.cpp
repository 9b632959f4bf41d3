// SPDX-License-Identifier: Apache-2.0
#include "pipeline/stages/history_stage.hpp"

#include <algorithm>

namespace choreo::pipeline {

void HistoryStage::process(Observation& observation) {
  std::size_t old = 0;
  while (old < times_.size() && times_[old] <= observation.time - length_) ++old;
  if (old == 0 && times_.size() == history_.capacity()) old = 1;
  history_.drop_oldest(old);
  times_.erase(times_.begin(), times_.begin() + static_cast<std::ptrdiff_t>(old));
  times_.push_back(observation.time);

  // Full: a row goes for this one, by time or by number.
  full_ = full_ || old > 0 || history_.size() == history_.capacity();
  const auto rows = std::min(history_.size() + 1, history_.capacity());
  observation.z_row.resize(rows);
  observation.zstar_row.resize(rows);
  const auto start = clock_.now();
  const bool body = append_(observation, observation.z_row, observation.zstar_row);
  if (cost_ != nullptr && body) cost_->add(clock_.now() - start, full_);
}

}  // namespace choreo::pipeline
