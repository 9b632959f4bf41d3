// SPDX-License-Identifier: Apache-2.0
// Looks for the person with the person network, some times a second.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/search_beside.hpp"
#include "pipeline/stage.hpp"
#include "vision/person/joint_filter.hpp"
#include "vision/person/person_search.hpp"

namespace choreo::pipeline {

struct PersonStageOptions {
  double looks_per_s = 10;            ///< By the frames' own times, [0.1, 1000]; no frame is looked at twice.
  std::optional<double> seeks_per_s;  ///< While nobody is seen, likewise; nothing: as often.
  double delay_s = 0.06;  ///< At least, from the frame that is looked at to the one that knows, [0, 2]; 0: the stage
                          ///< looks itself, and frames wait for it.
  bool first_at_once = false;  ///< Frames wait for the first look, which else has an effect as late as the others.
  bool others = true;          ///< Whether others are looked for as well.
  std::optional<double> arms_per_s = {};  ///< So many looks a second are for arms, [0.1, 1000]; nothing: none.
  std::size_t arm_looks = 2;              ///< So many looks in one then, and the arms fitted to all of them; 1 to 4.
  std::optional<vision::JointFilterOptions> smooth = {};  ///< Of the person's joints; nothing: as they are seen.
  bool waits = true;  ///< For a look that is not done when it is due; else it is due at the next frame again.
  /// Told of every frame at which a look was due and not done: its sequence number. Called by the thread that calls
  /// `process`.
  std::function<void(std::uint64_t)> on_late = {};

  void validate() const;  ///< @throws Error (usage) naming the option, its value and its range.
};

/// picture -> person, others.
///
/// There is one look at a time: a machine that is busy looks less often, and no frame waits. Which frames are looked at
/// depends on their times and on when looks took effect, where is looked on what they saw: the same frames and the same
/// late looks (Frame::late_person) give the same people. Comes after PictureStage. A frame without a picture is not
/// looked at.
class PersonStage final : public Stage {
 public:
  /// Frames that wait for a look get one that seeks everywhere; beside their way it seeks one part after the other.
  PersonStage(vision::PersonSearch search, PersonStageOptions options);

  [[nodiscard]] std::string name() const override { return "person"; }
  void process(Observation& observation) override;

  [[nodiscard]] std::uint64_t looks() const { return looks_; }  ///< That took effect so far.
  [[nodiscard]] std::uint64_t seen() const { return seen_; }    ///< Of these, those that showed somebody.

 private:
  struct Look;

  void take_effect(const std::shared_ptr<Look>& look, Observation& observation);

  PersonStageOptions options_;
  vision::PersonSearch search_;  // The looks'.
  vision::PersonTrack track_;
  vision::OthersTrack others_;
  std::optional<vision::JointFilter> filter_;
  std::shared_ptr<const PersonSighting> last_;
  std::vector<std::shared_ptr<const PersonSighting>> others_seen_;
  Nanoseconds seen_at_{0};  // The person, last.
  std::optional<Nanoseconds> next_, next_arms_;
  bool asked_ = false;
  std::uint64_t looks_ = 0, seen_ = 0;
  std::shared_ptr<Look> pending_;       // Asked for, and without effect so far.
  std::optional<SearchBeside> beside_;  // Last: its thread uses what is above.
};

}  // namespace choreo::pipeline
