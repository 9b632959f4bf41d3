// SPDX-License-Identifier: Apache-2.0
#include "cli/live_history.hpp"

#include <vector>

#include "similarity/mask_comparer.hpp"
#include "similarity/particle_comparer.hpp"

namespace choreo::cli {

LiveHistory::LiveHistory(bool particles, cv::Size picture, std::size_t capacity, similarity::AndCountKernel kernel)
    : kernel_(kernel) {
  if (particles) {
    particles_ = std::make_unique<similarity::ParticleHistory>(capacity);
  } else {
    masks_ = std::make_unique<similarity::MaskHistory>(picture, capacity, kernel);
  }
}

const similarity::History& LiveHistory::ring() const {
  if (particles_) return *particles_;
  return *masks_;
}

std::size_t LiveHistory::bytes_per_row(bool particles, cv::Size picture, similarity::AndCountKernel kernel) {
  const auto row = LiveHistory(particles, picture, 1, kernel).ring().bytes_per_row();
  return particles ? row + sizeof(std::optional<body::ParticleState>) : row;
}

std::unique_ptr<pipeline::Stage> LiveHistory::stage(Nanoseconds length, const Clock& clock, pipeline::RowCost* cost) {
  if (particles_) return std::make_unique<pipeline::HistoryStage>(*particles_, length, clock, cost);
  return std::make_unique<pipeline::HistoryStage>(*masks_, length, clock, cost);
}

std::unique_ptr<const similarity::Comparer> LiveHistory::comparer(const LiveRecordStage& record) {
  if (particles_) {
    const std::vector<std::optional<body::ParticleState>> states(record.particles().begin(), record.particles().end());
    return std::make_unique<similarity::ParticleComparer>(states);
  }
  std::vector<std::unique_ptr<const body::MaskState>> states;
  for (std::size_t age = 0; age < masks_->size(); ++age) states.push_back(masks_->state(age));
  auto comparer = std::make_unique<similarity::MaskComparer>(states, kernel_);
  canvas_ = comparer->canvas();
  return comparer;
}

}  // namespace choreo::cli
