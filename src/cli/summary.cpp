// SPDX-License-Identifier: Apache-2.0
#include "cli/summary.hpp"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <toml++/toml.h>

#include "config/schema.hpp"

namespace choreo::cli {
namespace {

using Json = nlohmann::ordered_json;

// Numbers that people read: enough digits, not all of them.
double rounded(double value, int digits) {
  const double scale = std::pow(10.0, digits);
  return std::round(value * scale) / scale;
}

Json json_of(cv::Size size) { return Json::array({size.width, size.height}); }

// The settings print themselves as TOML, whose numbers, flags, texts and lists are JSON as well.
Json settings_of(const config::Config& config) {
  Json settings = Json::object();
  for (const auto& field : config::schema()) {
    settings[field.key] = Json::parse(field.print(config.options()));
  }
  return settings;
}

}  // namespace

std::string to_json(const Summary& s, const config::Config& config) {
  Json json;
  json["source"] = s.source.name;
  json["size"] = json_of(s.source.size);
  json["working_size"] = json_of(s.working_size);
  json["span"] = s.span.empty() ? Json() : Json(s.span);
  json["every"] = s.every;
  json["frames"] = s.frames;
  json["frames_without_body"] = s.frames_without_body;
  json["frames_with_body_cut_by_the_frame"] = s.frames_with_body_cut;
  json["first_time_s"] = rounded(s.first_time_s, 6);
  json["last_time_s"] = rounded(s.last_time_s, 6);
  json["background"] = {{"from", config.options().background},
                        {"uncertain", s.background.uncertain()},
                        {"share_of_body_before_unseen_wall", rounded(s.background.unseen, 4)},
                        {"pieced_together", s.background.pieced},
                        {"share_of_body_inferred", rounded(s.inferred, 4)},
                        {"share_of_pictures_without_body", rounded(s.background.empty, 4)},
                        {"pictures", s.background_pictures},
                        {"noise_grey_levels", rounded(s.background.noise, 3)}};
  json["threshold_grey_levels"] = rounded(s.threshold, 3);
  json["sudden_changes_s"] = s.sudden_changes_s;
  json["compared_canvas"] = json_of(s.canvas);
  json["interrupted"] = s.interrupted;
  json["warnings"] = s.warnings;
  json["settings"] = settings_of(config);
  json["files"] = s.files;

  Json timings;
  timings["threads"] = s.threads;
  timings["instruction_set"] = s.instruction_set;
  timings["learn_background_s"] = rounded(to_seconds(s.learn_wall), 6);
  timings["frames_s"] = rounded(to_seconds(s.run.wall), 6);
  timings["all_pairs_s"] = rounded(to_seconds(s.pairs_wall), 6);
  timings["plots_s"] = rounded(to_seconds(s.plots_wall), 6);
  for (const auto& stage : s.run.stages) {
    timings["stages"].push_back({{"name", stage.name},
                                 {"frames", stage.frames},
                                 {"dropped", stage.dropped},
                                 {"busy_s", rounded(to_seconds(stage.busy), 6)},
                                 {"waiting_s", rounded(to_seconds(stage.waiting), 6)},
                                 {"mean_queue", rounded(stage.mean_queue, 3)},
                                 {"longest_queue", stage.longest_queue}});
  }
  json["timings"] = timings;
  // A file name may be anything; what is not UTF-8 is replaced rather than refused.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::vector<std::string> timing_table(const Summary& s) {
  std::vector<std::string> lines;
  lines.push_back(fmt::format("{:<10} {:>8} {:>8} {:>10} {:>10} {:>8} {:>8}", "stage", "frames", "dropped", "busy", "waiting",
                              "queue", "longest"));
  for (const auto& stage : s.run.stages) {
    lines.push_back(fmt::format("{:<10} {:>8} {:>8} {:>8.2f} s {:>8.2f} s {:>8.1f} {:>8}", stage.name, stage.frames,
                                stage.dropped, to_seconds(stage.busy), to_seconds(stage.waiting), stage.mean_queue,
                                stage.longest_queue));
  }
  lines.push_back(fmt::format("background {:.2f} s, frames {:.2f} s, all pairs {:.2f} s ({}), plots {:.2f} s",
                              to_seconds(s.learn_wall), to_seconds(s.run.wall), to_seconds(s.pairs_wall),
                              s.instruction_set, to_seconds(s.plots_wall)));
  return lines;
}

}  // namespace choreo::cli
