// SPDX-License-Identifier: Apache-2.0
// From where arms are seen to letters and words.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "pipeline/stage.hpp"
#include "recognition/arm_sign_reader.hpp"
#include "recognition/semaphore_reader.hpp"
#include "recognition/semaphore_speller.hpp"

namespace choreo::pipeline {

/// Whether signs are read of the person network's looks, or of particle states.
enum class ReadsSigns { kOfLooks, kOfParticles };

/// person or particles -> signal: what is shown now, what is held, the text so far. Times are of the frames that were
/// looked at.
class SemaphoreStage final : public Stage {
 public:
  /// @param bounds  those of the states, where these are read.
  /// @param history  how long signs are kept after their ends, > 0: a run without an end has memory for no more.
  ///   Nothing: all are kept.
  /// @throws Error (usage) by options.validate() and bounds.validate().
  SemaphoreStage(const recognition::SemaphoreOptions& options, const body::ParticleBounds& bounds, ReadsSigns reads,
                 std::optional<Nanoseconds> history = std::nullopt);

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
  [[nodiscard]] recognition::SemaphoreStep read(const Observation& observation);
  void take(const std::vector<recognition::HeldSign>& ended);
  void forget(double before_s);

  std::optional<Nanoseconds> history_;
  bool mirrored_;
  std::variant<recognition::ArmSignReader, recognition::SemaphoreReader> reader_;
  recognition::SemaphoreSpeller shown_;      // Has the end of the text, whatever is kept.
  recognition::SemaphoreSpeller forgotten_;  // Knows what the forgotten signs changed, and none of their text.
  std::vector<recognition::HeldSign> signs_;
  std::optional<double> since_;
  std::uint64_t ended_ = 0, letters_ = 0;
};

}  // namespace choreo::pipeline
