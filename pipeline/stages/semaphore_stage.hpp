// SPDX-License-Identifier: Apache-2.0
// From the particle state to letters and words.
#pragma once

#include <vector>

#include "pipeline/stage.hpp"
#include "recognition/semaphore_reader.hpp"
#include "recognition/semaphore_speller.hpp"

namespace choreo::pipeline {

/// particles -> signal: what is shown now, what is held, the text so far.
class SemaphoreStage final : public Stage {
 public:
  /// @param bounds  those of the states.
  /// @throws Error (usage) by options.validate() and bounds.validate().
  SemaphoreStage(const recognition::SemaphoreOptions& options, const body::ParticleBounds& bounds)
      : reader_(options, bounds), speller_(options) {}

  [[nodiscard]] std::string name() const override { return "semaphore"; }
  void process(Observation& observation) override;

  /// Ends what is being held. No frame may come afterwards.
  void finish();

  /// All signs that are over, in the order of their ends; times in seconds since the source's first frame.
  [[nodiscard]] const std::vector<recognition::HeldSign>& signs() const { return signs_; }
  [[nodiscard]] const std::string& text() const { return speller_.text(); }

 private:
  void take(const std::vector<recognition::HeldSign>& ended);

  recognition::SemaphoreReader reader_;
  recognition::SemaphoreSpeller speller_;
  std::vector<recognition::HeldSign> signs_;
};

}  // namespace choreo::pipeline
