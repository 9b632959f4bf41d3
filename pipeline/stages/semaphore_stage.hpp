// SPDX-License-Identifier: Apache-2.0
// From the particle state to letters and words.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/stage.hpp"
#include "recognition/semaphore_reader.hpp"
#include "recognition/semaphore_speller.hpp"

namespace choreo::pipeline {

/// particles -> signal: what is shown now, what is held, the text so far.
class SemaphoreStage final : public Stage {
 public:
  /// @param bounds  those of the states.
  /// @param history  how long signs are kept after their ends, > 0: a run without an end has memory for no more.
  ///   Nothing: all are kept.
  /// @throws Error (usage) by options.validate() and bounds.validate().
  SemaphoreStage(const recognition::SemaphoreOptions& options, const body::ParticleBounds& bounds,
                 std::optional<Nanoseconds> history = std::nullopt)
      : history_(history), reader_(options, bounds), shown_(options), forgotten_(options) {}

  [[nodiscard]] std::string name() const override { return "semaphore"; }
  void process(Observation& observation) override;

  /// Ends what is being held. No frame may come afterwards.
  void finish();

  /// The signs that are over and kept, in the order of their ends; times in seconds since the source's first frame.
  [[nodiscard]] const std::vector<recognition::HeldSign>& signs() const { return signs_; }
  /// What these wrote: the end of what all signs wrote, a digit a digit whenever NUMERALS was shown.
  [[nodiscard]] std::string text() const;
  /// Where a letter was forgotten: no sign that ended before this is kept. In seconds as theirs.
  [[nodiscard]] std::optional<double> since() const { return since_; }
  [[nodiscard]] std::uint64_t ended() const { return ended_; }      ///< Signs so far, kept or not.
  [[nodiscard]] std::uint64_t letters() const { return letters_; }  ///< Of these, all but REST.

 private:
  void take(const std::vector<recognition::HeldSign>& ended);
  void forget(double before_s);

  std::optional<Nanoseconds> history_;
  recognition::SemaphoreReader reader_;
  recognition::SemaphoreSpeller shown_;      // Has the end of the text, whatever is kept.
  recognition::SemaphoreSpeller forgotten_;  // Knows what the forgotten signs changed, and none of their text.
  std::vector<recognition::HeldSign> signs_;
  std::optional<double> since_;
  std::uint64_t ended_ = 0, letters_ = 0;
};

}  // namespace choreo::pipeline
