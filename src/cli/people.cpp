// SPDX-License-Identifier: Apache-2.0
#include "cli/people.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "pipeline/person_evidence.hpp"
#include "pipeline/person_models.hpp"

namespace choreo::cli {

vision::PersonSearch load_people(const config::Options& settings) {
  using vision::PersonChoice;
  const auto& choose = settings.person.choose;
  const auto choice = choose == "left"     ? PersonChoice::kLeft
                      : choose == "middle" ? PersonChoice::kMiddle
                      : choose == "right"  ? PersonChoice::kRight
                                           : PersonChoice::kLargest;
  return pipeline::load_person_search({settings.person.models, settings.person.network == "lite", choice});
}

pipeline::OtherPeople others_of(const config::Options& settings) {
  return settings.person.others == "bodies" ? pipeline::OtherPeople::kBodies : pipeline::OtherPeople::kLeftOut;
}

std::string lacks_people(const config::Options& settings) {
  if (!settings.person.models.empty()) return {};
  return pipeline::missing_person_models({{}, settings.person.network == "lite"});
}

std::vector<vision::PersonEvidence> people_in(std::span<const cv::Mat> pictures, vision::PersonSearch& first,
                                              const config::Options& settings, const std::stop_token& stop) {
  // Each begins anew, so that it is the same with any number of threads, and loads its own networks: a tenth of a
  // second.
  constexpr std::size_t kOfAStretch = 15;
  const auto stretches = (pictures.size() + kOfAStretch - 1) / kOfAStretch;
  std::vector<vision::PersonEvidence> out(pictures.size());
  std::vector<std::optional<vision::PersonRegion>> near(pictures.size());  // Where to look in the pictures beside it.
  tbb::parallel_for(std::size_t{0}, stretches, [&](std::size_t k) {
    const auto end = (k + 1) * pictures.size() / stretches;
    std::optional<vision::PersonSearch> own;
    auto& search = k == 0 ? first : own.emplace(load_people(settings));
    vision::PersonTrack track;
    vision::OthersTrack others;
    for (auto i = k * pictures.size() / stretches; i < end && !stop.stop_requested(); ++i) {
      const auto look = search.search(pictures[i], track.next());
      track.update(look);
      if (!look) continue;
      near[i] = look->next;
      // None of them is background.
      out[i] = pipeline::evidence_of(*look, pictures[i].size());
      auto query = others.next();
      constexpr std::size_t kSeeks = 5;
      query.seek = query.seek || i % kSeeks == 0;
      const auto seen = search.search_others(pictures[i], query, look);
      others.update(query, seen, 0);
      for (const auto& other : seen) {
        if (other) out[i] = vision::together(out[i], pipeline::evidence_of(*other, pictures[i].size()));
      }
    }
  });
  // Who was found late, or lost for a picture, is where they are seen to be a picture later or earlier.
  const auto look_from = [&](std::size_t i, std::size_t beside) {
    if (near[i] || !near[beside] || stop.stop_requested()) return;
    const auto look = first.search(pictures[i], {near[beside], 0});
    if (!look) return;
    near[i] = look->next;
    out[i] = pipeline::evidence_of(*look, pictures[i].size());
    vision::OthersQuery query;
    query.seek = true;
    for (const auto& other : first.search_others(pictures[i], query, look)) {
      out[i] = vision::together(out[i], pipeline::evidence_of(*other, pictures[i].size()));
    }
  };
  for (std::size_t i = pictures.size(); i-- > 1;) look_from(i - 1, i);
  for (std::size_t i = 1; i < pictures.size(); ++i) look_from(i, i - 1);
  return out;
}

static std::optional<vision::JointFilterOptions> smooth_of(const config::Options& settings) {
  if (settings.person.smooth_hz == 0) return std::nullopt;
  return vision::JointFilterOptions{settings.person.smooth_hz, settings.person.smooth_hz_per_mps};
}

std::unique_ptr<pipeline::PersonStage> person_stage(vision::PersonSearch search, const config::Options& settings,
                                                    bool masks, bool somebody, bool arms) {
  pipeline::PersonStageOptions options;
  options.delay_s = 0;
  options.others = masks;
  options.smooth = smooth_of(settings);
  // A mask between two looks is a guess where anything moves fast, and a recording has time.
  constexpr double kEveryFrame = 1000;
  options.looks_per_s = masks ? kEveryFrame : settings.person.looks_per_s;
  if (arms) options.arms_per_s = settings.person.looks_per_s;
  options.arm_looks = 4;
  if (!somebody) options.seeks_per_s = settings.person.looks_per_s;
  return std::make_unique<pipeline::PersonStage>(std::move(search), std::move(options));
}

std::unique_ptr<pipeline::PersonStage> person_stage_beside(const config::Options& settings, bool arms,
                                                           std::function<void(std::uint64_t)> on_late) {
  pipeline::PersonStageOptions options;
  options.delay_s = settings.person.delay_s;
  options.looks_per_s = settings.person.looks_per_s;
  options.others = settings.segmentation == "auto" || settings.segmentation == "person";
  options.smooth = smooth_of(settings);
  if (arms) options.arms_per_s = settings.person.looks_per_s;
  options.first_at_once = true;  // Nothing was shown yet.
  options.waits = on_late == nullptr;
  options.on_late = std::move(on_late);
  return std::make_unique<pipeline::PersonStage>(load_people(settings), std::move(options));
}

void JointsRecord::process(pipeline::Observation& o) {
  frames_.push_back({o.frame->sequence + 1, to_seconds(o.time)});
  if (o.looked) {
    const auto time_s = to_seconds(*o.looked);
    looks_.emplace_back(time_s, o.person ? &o.person->look : nullptr);
    smooth_.emplace_back(time_s, o.person && o.person->smooth ? &*o.person->smooth : nullptr);
  }
  if (keeps_ == Keeps::kAll) return;
  while (frames_.size() > o.z_row.size()) frames_.pop_front();
  // The last look before them says where the first of them are between.
  while (looks_.size() > 1 && looks_[1].time_s <= frames_.front().time_s) {
    looks_.pop_front();
    smooth_.pop_front();
  }
}

std::uint64_t JointsRecord::bytes_of(std::size_t frames, double seconds, const config::Options& settings) {
  const double looks = std::min(double(frames), settings.person.looks_per_s * seconds);
  return frames * sizeof(outputs::JointsFrame) + std::uint64_t(2 * looks) * sizeof(outputs::JointsLook);
}

std::vector<std::string> JointsRecord::files(const config::Options& settings) {
  std::vector<std::string> names{"joints.csv"};
  if (settings.person.smooth_hz > 0) names.emplace_back("joints_smooth.csv");
  return names;
}

void JointsRecord::write(outputs::OutputSet& files, const config::Options& settings) const {
  const std::vector frames(frames_.begin(), frames_.end());
  for (const auto& name : JointsRecord::files(settings)) {
    const auto& looks = name == "joints.csv" ? looks_ : smooth_;
    outputs::write_file(files.add(name), outputs::joints_csv(frames, std::vector(looks.begin(), looks.end())));
  }
}

std::optional<std::string> few_looks(const pipeline::PersonStage& person, const config::Options& settings,
                                     double seconds, std::uint64_t frames) {
  // One at a time, and none sooner than the next frame.
  const double most = std::min(seconds / settings.person.delay_s, double(frames));
  const double wanted = std::min(settings.person.looks_per_s * seconds, most);
  if (2 * (double(person.looks()) + 1) >= wanted) return std::nullopt;
  return fmt::format(
      "the machine was too busy to look for the person more often than {:.1f} times a second; person.looks_per_s asks "
      "for {:g} (person.network = \"lite\" is the quick network)",
      double(person.looks()) / seconds, settings.person.looks_per_s);
}

}  // namespace choreo::cli
