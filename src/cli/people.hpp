// SPDX-License-Identifier: Apache-2.0
// What analyze and live share of looking for people.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "config/options.hpp"
#include "core/time.hpp"
#include "outputs/joints_csv.hpp"
#include "pipeline/stage.hpp"
#include "pipeline/stages/person_stage.hpp"

namespace choreo::cli {

/// The stage of a recording, whose frames wait for looks, as quick as two threads are.
/// @throws Error (usage) where a network is missing or cannot be used.
[[nodiscard]] std::unique_ptr<pipeline::PersonStage> person_stage(const config::Options& settings);

/// The stage of a live run, which looks beside the frames.
/// @param on_late  told the number of a frame at which a look was due and not done; empty: every look is waited for.
/// @throws Error (usage) likewise.
[[nodiscard]] std::unique_ptr<pipeline::PersonStage> person_stage_beside(const config::Options& settings,
                                                                         std::function<void(std::uint64_t)> on_late);

/// Keeps the joints of every look, of a live run those of its history.
class JointsRecord final : public pipeline::Stage {
 public:
  /// @param history  what is older than this is forgotten; nothing: it is all kept.
  explicit JointsRecord(std::optional<Nanoseconds> history = std::nullopt) : history_(history) {}

  [[nodiscard]] std::string name() const override { return "joints"; }
  void process(pipeline::Observation& observation) override;

  [[nodiscard]] std::string csv() const;

 private:
  std::optional<Nanoseconds> history_;
  std::deque<outputs::JointsFrame> frames_;
  std::deque<outputs::JointsLook> looks_;
};

/// After a live run of so many seconds: one line where it looked less than half as often as the settings ask for.
[[nodiscard]] std::optional<std::string> few_looks(const pipeline::PersonStage& person, const config::Options& settings,
                                                   double seconds);

}  // namespace choreo::cli
