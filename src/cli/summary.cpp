// SPDX-License-Identifier: Apache-2.0
#include "cli/summary.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <toml++/toml.h>
#include <nlohmann/json.hpp>

#include "config/schema.hpp"
#include "core/text.hpp"

namespace choreo::cli {
namespace {

using Json = nlohmann::ordered_json;

// Numbers that people read: enough digits, not all of them.
double rounded(double value, int digits) {
  const double scale = std::pow(10.0, digits);
  return std::round(value * scale) / scale;
}

Json json_of(cv::Size size) { return Json::array({size.width, size.height}); }

Json json_of(const pipeline::Latency& l) {
  const auto ms = [](Nanoseconds t) { return rounded(1e3 * to_seconds(t), 4); };
  return {{"p50", ms(l.p50)}, {"p99", ms(l.p99)}, {"p99.9", ms(l.p999)}, {"max", ms(l.max)}};
}

std::uint64_t dropped(const pipeline::RunReport& run) {
  std::uint64_t sum = 0;
  for (const auto& stage : run.stages) sum += stage.dropped;
  return sum;
}

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
  json["frames_seen"] = s.run.frames;
  json["thinned_to_every"] = s.thinned_to_every;
  json["frames"] = s.frames;
  json["frames_without_body"] = s.frames_without_body;
  json["frames_with_body_cut_by_the_frame"] = s.frames_with_body_cut;
  json["first_time_s"] = rounded(s.first_time_s, 6);
  json["last_time_s"] = rounded(s.last_time_s, 6);
  json["segmentation"] = config.options().segmentation;
  if (!s.body.empty()) json["body"] = s.body;
  json["background"] = {{"from", config.options().background},
                        {"uncertain", s.uncertain()},
                        {"share_of_body_before_unseen_wall", rounded(s.background.unseen, 4)},
                        {"share_of_body_inferred", rounded(s.inferred, 4)},
                        {"share_of_pictures_without_body", rounded(s.background.empty, 4)},
                        {"camera_shakes", s.background.camera == vision::CameraKind::kShakes},
                        {"share_of_frames_in_which_the_camera_moved", rounded(s.camera_moved, 4)},
                        {"share_of_picture_that_moves_in_place", rounded(s.background.dynamic.share(), 4)},
                        {"pictures", s.background_pictures},
                        {"noise_grey_levels", rounded(s.background.noise, 3)}};
  json["threshold_grey_levels"] = s.threshold ? Json(rounded(*s.threshold, 3)) : Json();
  if (s.depth) {
    json["depth"] = {{"share_of_room_known", rounded(s.depth->known_share(), 4)},
                     {"share_of_room_inferred", rounded(s.depth->inferred_share(), 4)},
                     {"share_of_pictures_without_body", rounded(s.depth->empty, 4)},
                     {"noise_mm_at_2_m", rounded(4e6 * s.depth->noise_per_mm, 3)}};
  }
  json["sudden_changes_s"] = s.sudden_changes_s;
  json["state"] = s.particles ? "particles" : "mask";
  json["compared_canvas"] = json_of(s.canvas);
  if (s.live) {
    json["live"] = {{"pace", s.live->pace},
                    {"history_s", rounded(s.live->history_s, 6)},
                    {"capacity_rows", s.live->capacity_rows},
                    {"bytes_per_row", s.live->bytes_per_row},
                    {"history_bytes", s.live->history_bytes},
                    {"rows", s.live->rows}};
  }
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
    if (stage.latency.count > 0) timings["stages"].back()["latency_ms"] = json_of(stage.latency);
  }
  timings["latency_ms"] = json_of(s.run.latency);
  if (s.live) {
    timings["dropped"] = dropped(s.run);
    timings["row_ms_ring_full"] = json_of(s.live->row_full);
    timings["row_ms_ring_filling"] = json_of(s.live->row_filling);
  }
  json["timings"] = timings;
  // A file name may be anything; what is not UTF-8 is replaced rather than refused.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::vector<std::string> timing_table(const Summary& s) {
  std::vector<std::string> lines;
  lines.push_back(fmt::format("{:<10} {:>8} {:>8} {:>10} {:>10} {:>8} {:>8}", "stage", "frames", "dropped", "busy",
                              "waiting", "queue", "longest"));
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

std::string latency_heading() {
  return fmt::format("{:<10} {:>9} {:>9} {:>9} {:>9}", "latency", "p50", "p99", "p99.9", "max");
}

std::string latency_line(const std::string& name, const pipeline::Latency& l) {
  const auto ms = [](Nanoseconds t) { return 1e3 * to_seconds(t); };
  return fmt::format("{:<10} {:>9.2f} {:>9.2f} {:>9.2f} {:>9.2f} ms", name, ms(l.p50), ms(l.p99), ms(l.p999),
                     ms(l.max));
}

std::vector<std::string> live_table(const Summary& s) {
  std::vector<std::string> lines{latency_heading()};
  for (const auto& stage : s.run.stages) {
    if (stage.latency.count > 0) lines.push_back(latency_line(stage.name, stage.latency));
  }
  lines.push_back(latency_line("end to end", s.run.latency));
  const auto& live = *s.live;
  const bool full = live.row_full.count > 0;
  const auto& row = full ? live.row_full : live.row_filling;
  lines.push_back(fmt::format("{} in {:.1f} s ({:.1f} a second), {} dropped", counted(s.run.frames, "frame"),
                              to_seconds(s.run.wall), double(s.run.frames) / std::max(1e-9, to_seconds(s.run.wall)),
                              dropped(s.run)));
  lines.push_back(fmt::format(
      "history {} of {} rows of {} bytes, {:.1f} MB; a row with the ring {} costs {:.3f} ms, p99 {:.3f} ms ({})",
      live.rows, live.capacity_rows, live.bytes_per_row, 1e-6 * double(live.history_bytes),
      full ? "full" : "not yet full", 1e3 * to_seconds(row.p50), 1e3 * to_seconds(row.p99), s.instruction_set));
  return lines;
}

}  // namespace choreo::cli
