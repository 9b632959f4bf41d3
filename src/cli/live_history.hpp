// SPDX-License-Identifier: Apache-2.0
// The ring of states of a live run, whichever state stands for the body.
#pragma once

#include <memory>

#include "cli/live_record.hpp"
#include "pipeline/stages/history_stage.hpp"
#include "similarity/comparer.hpp"
#include "similarity/mask_history.hpp"
#include "similarity/particle_history.hpp"

namespace choreo::cli {

class LiveHistory {
 public:
  /// @param picture  size of the pictures that masks come from.
  LiveHistory(bool particles, cv::Size picture, std::size_t capacity, similarity::AndCountKernel kernel);

  [[nodiscard]] const similarity::History& ring() const;
  /// What a row of such a ring takes, what is kept beside it included; in bytes.
  [[nodiscard]] static std::size_t bytes_per_row(bool particles, cv::Size picture, similarity::AndCountKernel kernel);

  /// The stage that fills it; this must outlive that.
  [[nodiscard]] std::unique_ptr<pipeline::Stage> stage(Nanoseconds length, const Clock& clock, pipeline::RowCost* cost);

  /// What compares all that is in it.
  /// @param record  of as many rows.
  [[nodiscard]] std::unique_ptr<const similarity::Comparer> comparer(const LiveRecordStage& record);
  /// Of the compared pictures, once `comparer` was made; 0 x 0 for particles.
  [[nodiscard]] cv::Size canvas() const { return canvas_; }

 private:
  similarity::AndCountKernel kernel_;
  std::unique_ptr<similarity::MaskHistory> masks_;          // Either this
  std::unique_ptr<similarity::ParticleHistory> particles_;  // or this.
  cv::Size canvas_;
};

}  // namespace choreo::cli
