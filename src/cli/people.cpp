// SPDX-License-Identifier: Apache-2.0
#include "cli/people.hpp"

#include <utility>
#include <vector>

#include <fmt/format.h>

#include "pipeline/person_models.hpp"

namespace choreo::cli {
namespace {

std::unique_ptr<pipeline::PersonStage> make(const config::Options& settings, int threads,
                                            pipeline::PersonStageOptions options) {
  options.looks_per_s = settings.person.looks_per_s;
  auto search = pipeline::load_person_search({settings.person.models, settings.person.network == "lite", threads});
  return std::make_unique<pipeline::PersonStage>(std::move(search), std::move(options));
}

}  // namespace

std::unique_ptr<pipeline::PersonStage> person_stage(const config::Options& settings) {
  pipeline::PersonStageOptions options;
  options.delay_frames = 0;
  return make(settings, 2, std::move(options));
}

std::unique_ptr<pipeline::PersonStage> person_stage_beside(const config::Options& settings,
                                                           std::function<void(std::uint64_t)> on_late) {
  pipeline::PersonStageOptions options;
  options.delay_frames = settings.person.delay_frames;
  options.waits = on_late == nullptr;
  options.on_late = std::move(on_late);
  return make(settings, 1, std::move(options));
}

void JointsRecord::process(pipeline::Observation& o) {
  frames_.push_back({o.frame->sequence + 1, to_seconds(o.time)});
  if (o.looked) looks_.emplace_back(to_seconds(*o.looked), o.person ? &o.person->look : nullptr);
  if (!history_) return;
  const double oldest = to_seconds(o.time - *history_);
  while (frames_.front().time_s < oldest) frames_.pop_front();
  while (!looks_.empty() && looks_.front().time_s < oldest) looks_.pop_front();
}

std::string JointsRecord::csv() const {
  return outputs::joints_csv(std::vector(frames_.begin(), frames_.end()), std::vector(looks_.begin(), looks_.end()));
}

std::optional<std::string> few_looks(const pipeline::PersonStage& person, const config::Options& settings,
                                     double seconds) {
  const double wanted = settings.person.looks_per_s * seconds;
  if (2 * (double(person.looks()) + 1) >= wanted) return std::nullopt;
  return fmt::format(
      "the machine was too busy to look for the person more often than {:.1f} times a second; person.looks_per_s asks "
      "for {:g} (person.network = \"lite\" is the quick network)",
      double(person.looks()) / seconds, settings.person.looks_per_s);
}

}  // namespace choreo::cli
