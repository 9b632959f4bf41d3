// SPDX-License-Identifier: Apache-2.0
// What analyze and live share of looking for people.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "config/options.hpp"
#include "core/time.hpp"
#include "outputs/joints_csv.hpp"
#include "outputs/output_set.hpp"
#include "pipeline/person_evidence.hpp"
#include "pipeline/stage.hpp"
#include "pipeline/stages/person_stage.hpp"
#include "vision/person_masker.hpp"

namespace choreo::cli {

/// The network that the settings name. @throws Error (usage) where a file is missing or cannot be used.
[[nodiscard]] vision::PersonSearch load_people(const config::Options& settings);

/// What becomes of the others who are seen.
[[nodiscard]] pipeline::OtherPeople others_of(const config::Options& settings);

/// The files of the usual folder that are missing; empty: none. A folder that was chosen has to have them.
[[nodiscard]] std::string lacks_people(const config::Options& settings);

/// Where somebody is in pictures of one scene, in order of time; several are looked at at once.
/// @param first  load_people's; others are loaded where they are needed.
/// @return one a picture, in their order; whatever where `stop` was requested.
/// @throws Error (usage) as load_people.
[[nodiscard]] std::vector<vision::PersonEvidence> people_in(std::span<const cv::Mat> pictures,
                                                            vision::PersonSearch& first,
                                                            const config::Options& settings,
                                                            const std::stop_token& stop);

/// The stage of a recording, whose frames wait for looks.
/// @param masks  masks are made of people: who is there is looked at in every frame.
/// @param somebody  is likely to be there; where nobody is, frames are looked at now and then.
/// @param arms  signs are read of them.
[[nodiscard]] std::unique_ptr<pipeline::PersonStage> person_stage(vision::PersonSearch search,
                                                                  const config::Options& settings, bool masks,
                                                                  bool somebody, bool arms);

/// The stage of a live run, which looks beside the frames.
/// @param arms  signs are read of them.
/// @param on_late  told the number of a frame at which a look was due and not done; empty: every look is waited for.
/// @throws Error (usage) likewise.
[[nodiscard]] std::unique_ptr<pipeline::PersonStage> person_stage_beside(const config::Options& settings, bool arms,
                                                                         std::function<void(std::uint64_t)> on_late);

/// Keeps the joints of every look, of a live run those of the frames in its history.
class JointsRecord final : public pipeline::Stage {
 public:
  enum class Keeps { kAll, kHistory };

  /// @param keeps  kHistory comes after HistoryStage, and forgets the frames that it forgets.
  explicit JointsRecord(Keeps keeps) : keeps_(keeps) {}

  /// Bytes of a history of so many frames and so many seconds, at most.
  [[nodiscard]] static std::uint64_t bytes_of(std::size_t frames, double seconds, const config::Options& settings);

  [[nodiscard]] std::string name() const override { return "joints"; }
  void process(pipeline::Observation& observation) override;

  /// joints.csv, and joints_smooth.csv where joints are filtered.
  [[nodiscard]] static std::vector<std::string> files(const config::Options& settings);
  void write(outputs::OutputSet& files, const config::Options& settings) const;

 private:
  Keeps keeps_;
  std::deque<outputs::JointsFrame> frames_;
  std::deque<outputs::JointsLook> looks_, smooth_;  // Of the same times.
};

/// After a live run of so many seconds and frames: one line where it looked less than half as often as the settings ask
/// for, and as one look at a time allows.
[[nodiscard]] std::optional<std::string> few_looks(const pipeline::PersonStage& person, const config::Options& settings,
                                                   double seconds, std::uint64_t frames);

}  // namespace choreo::cli
