// SPDX-License-Identifier: Apache-2.0
#include "config/schema.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "config/field_kinds.hpp"
#include "config/signal_fields.hpp"
#include "core/error.hpp"
#include "core/time.hpp"

namespace choreo::config {
namespace {

// Of a plate only that it is named: whether it is there is for whoever reads it.
bool fits_background(const std::string& text) {
  constexpr std::string_view kFirst = "first:";
  if (!text.starts_with(kFirst)) return !text.empty();
  try {
    return parse_duration(text.substr(kFirst.size())) > Nanoseconds{0};
  } catch (const Error&) {
    return false;
  }
}

std::optional<vision::Zone> zone_of(const toml::node& node) {
  const auto n = numbers_of(node);
  if (!n || n->size() != 4) return std::nullopt;
  const vision::Zone zone{(*n)[0], (*n)[1], (*n)[2], (*n)[3]};
  return zone.valid() ? std::optional(zone) : std::nullopt;
}

std::string print_zone(const vision::Zone& z) { return fmt::format("[{}, {}, {}, {}]", z.x0, z.y0, z.x1, z.y1); }

Field zone(std::string key, vision::Zone& (*at)(Options&), std::string range_text, std::string help) {
  return {std::move(key),
          std::move(range_text),
          std::move(help),
          false,
          [=](Options& o, const toml::node& node) {
            const auto value = zone_of(node);
            if (value) at(o) = *value;
            return value.has_value();
          },
          [=](const Options& o) { return print_zone(at(const_cast<Options&>(o))); }};
}

Field zones(std::string key, std::vector<vision::Zone>& (*at)(Options&), std::string range_text, std::string help) {
  constexpr std::size_t kMost = 64;
  return {std::move(key),
          std::move(range_text),
          std::move(help),
          false,
          [=](Options& o, const toml::node& node) {
            const auto* array = node.as_array();
            if (array == nullptr || array->size() > kMost) return false;
            std::vector<vision::Zone> all;
            for (const auto& item : *array) {
              const auto value = zone_of(item);
              if (!value) return false;
              all.push_back(*value);
            }
            at(o) = std::move(all);
            return true;
          },
          [=](const Options& o) {
            std::vector<std::string> all;
            for (const auto& z : at(const_cast<Options&>(o))) all.push_back(print_zone(z));
            return fmt::format("[{}]", fmt::join(all, ", "));
          }};
}

Field times(std::string key, std::vector<double>& (*at)(Options&), std::string range_text, std::string help) {
  constexpr std::size_t kMost = 64;
  return {std::move(key),
          std::move(range_text),
          std::move(help),
          false,
          [=](Options& o, const toml::node& node) {
            auto all = numbers_of(node);
            if (!all || all->size() > kMost || std::any_of(all->begin(), all->end(), [](double t) { return t < 0; })) {
              return false;
            }
            at(o) = std::move(*all);
            return true;
          },
          [=](const Options& o) { return fmt::format("[{}]", fmt::join(at(const_cast<Options&>(o)), ", ")); }};
}

std::vector<Field> make_schema() {
  std::vector<Field> fields;
  fields.push_back(text(
      "segmentation", [](Options& o) -> std::string& { return o.segmentation; },
      one_of({"auto", "colour", "depth", "both", "person"}), "\"auto\", \"colour\", \"depth\", \"both\" or \"person\"",
      "What tells the body from the room: its colour, its being nearer, depth with colour along its edges, or the "
      "person network with colour along its edges; auto is the person once the network saw one, and colour until then "
      "or without the network."));

  fields.push_back(text(
      "background.from", [](Options& o) -> std::string& { return o.background; }, fits_background,
      "\"auto\", \"first:T\" (T a duration such as 1s), or the path of a picture of the empty room",
      "Where the picture of the empty room comes from: estimated over the whole clip, the median of its beginning, or "
      "a plate."));
  fields.push_back(flag(
      "background.follow_exposure", [](Options& o) -> bool& { return o.mask.follow_exposure; },
      "Bring the background to each picture's exposure, white balance and tone, which cameras change by themselves."));
  fields.push_back(number(
      "background.follow_s", [](Options& o) -> double& { return o.mask.follow_s; }, {0, 3600}, "from 0 (off) to 3600 s",
      "Time constant with which the background follows slow changes of light, outside the body."));
  fields.push_back(number(
      "background.sudden_percent", [](Options& o) -> double& { return o.mask.sudden_percent; }, {1, 100},
      "from 1 to 100 % of the picture (100: off)",
      "A change of more than this share of the picture is a change of light or scene, not a body."));
  fields.push_back(number(
      "background.relearn_s", [](Options& o) -> double& { return o.mask.relearn_s; }, {0, 60}, "from 0 to 60 s",
      "How long the background is learned anew after a change of scene; so long there is no body."));

  fields.push_back(number_or_auto(
      "mask.threshold", [](Options& o) -> std::optional<double>& { return o.mask.threshold; }, {0, 255, true},
      "above 0 and at most 255 grey levels, or \"auto\"",
      "How much a pixel must differ from the background to be body; auto takes it from the measured noise."));
  fields.push_back(number(
      "mask.noise_factor", [](Options& o) -> double& { return o.mask.noise_factor; }, {1, 20}, "from 1 to 20",
      "The automatic threshold over the standard deviation of the noise."));
  fields.push_back(number(
      "mask.least_threshold", [](Options& o) -> double& { return o.mask.least_threshold; }, {1, 255},
      "from 1 to 255 grey levels", "The automatic threshold is never lower."));
  fields.push_back(integer(
      "mask.steps", [](Options& o) -> int& { return o.mask.steps; }, 0, 32, "from 0 to 32 pixels",
      "Annealing: so many grow steps, then as many shrink steps; closes gaps up to twice as wide."));
  fields.push_back(flag(
      "mask.half_contrast_edge", [](Options& o) -> bool& { return o.mask.half_contrast_edge; },
      "Take back halos and edge pixels that are more wall than body."));
  fields.push_back(flag(
      "mask.drop_soft_light", [](Options& o) -> bool& { return o.mask.drop_soft_light; },
      "Take away soft shadows and glows on the wall and floor."));
  fields.push_back(flag(
      "mask.largest_only", [](Options& o) -> bool& { return o.mask.largest_only; },
      "Keep the largest connected part alone: one performer, and passers-by are ignored."));
  fields.push_back(number(
      "mask.speck_percent", [](Options& o) -> double& { return o.mask.speck_percent; }, {0, 100},
      "from 0 to 100 % of the picture", "Connected parts smaller than this go."));
  fields.push_back(number(
      "mask.min_body_percent", [](Options& o) -> double& { return o.mask.min_body_percent; }, {0, 100},
      "from 0 to 100 % of the picture", "A mask smaller than this is no body."));
  fields.push_back(zone(
      "mask.roi", [](Options& o) -> vision::Zone& { return o.mask.roi; },
      "[left, top, right, bottom] in fractions of the picture, 0 to 1", "Only what lies inside can be body."));
  fields.push_back(zones(
      "mask.ignore", [](Options& o) -> std::vector<vision::Zone>& { return o.mask.ignore; },
      "a list of at most 64 zones like mask.roi",
      "What lies inside any of these is no body: a screen, a fan, a mirror."));

  fields.push_back(number_or_auto(
      "depth.threshold_mm", [](Options& o) -> std::optional<double>& { return o.depth.threshold_mm; }, {0, 5000, true},
      "above 0 and at most 5000 mm, or \"auto\"",
      "How much nearer than the room a pixel must be to be body; auto takes it from the spread of its readings."));
  fields.push_back(number(
      "depth.spread_factor", [](Options& o) -> double& { return o.depth.spread_factor; }, {1, 20}, "from 1 to 20",
      "The automatic threshold over the standard deviation of a pixel's readings."));
  fields.push_back(number(
      "depth.least_threshold_mm", [](Options& o) -> double& { return o.depth.least_threshold_mm; }, {1, 1000},
      "from 1 to 1000 mm", "The automatic threshold is never lower."));
  fields.push_back(number(
      "depth.near_mm", [](Options& o) -> double& { return o.depth.near_mm; }, {0, 20000}, "from 0 to 20000 mm",
      "What is nearer to the camera is no body."));
  fields.push_back(number(
      "depth.far_mm", [](Options& o) -> double& { return o.depth.far_mm; }, {0, 20000},
      "from 0 (no such plane) to 20000 mm",
      "What is farther is no body; what is nearer is, also where the room's own depth is unknown."));

  for (auto& field : signal_fields()) fields.push_back(std::move(field));

  fields.push_back(integer(
      "working.rows", [](Options& o) -> int& { return o.working_rows; }, 0, 8640,
      "from 0 (the picture's own) to 8640 rows",
      "Masks and states are made of pictures scaled down to at most so many rows."));
  fields.push_back(number(
      "motion.window_s", [](Options& o) -> double& { return o.motion_window_s; }, {0, 10, true},
      "above 0 and at most 10 s", "How far back the quantity of motion looks."));

  fields.push_back(integer(
      "matrix.most_rows", [](Options& o) -> int& { return o.matrix_rows; }, 2, 1'000'000, "from 2 to 1000000 rows",
      "Of a recording with more frames every 2nd is kept, every 4th, ... until there are at most so many rows."));

  fields.push_back(text(
      "plot.channels", [](Options& o) -> std::string& { return o.plot.channels; }, one_of({"both", "z", "zstar"}),
      "\"both\", \"z\" or \"zstar\"", "Z in red with Z* in cyan, or one of them alone in grey."));
  fields.push_back(text(
      "plot.page", [](Options& o) -> std::string& { return o.plot.page; }, one_of({"light", "dark"}),
      "\"light\" or \"dark\"", "A page to print or one to project."));
  fields.push_back(flag(
      "plot.svg", [](Options& o) -> bool& { return o.plot.svg; }, "Write each plot as SVG too."));
  fields.push_back(integer(
      "plot.width_px", [](Options& o) -> int& { return o.plot.width_px; }, 320, 8000, "from 320 to 8000 pixels",
      "Width of the plots."));
  fields.push_back(text(
      "plot.contrast", [](Options& o) -> std::string& { return o.plot.contrast; }, one_of({"full", "auto"}),
      "\"full\" or \"auto\"", "Brightness from 0 to 1, or stretched from the least similarities of the clip to 1."));
  fields.push_back(integer(
      "plot.thumbnails", [](Options& o) -> int& { return o.plot.thumbnails; }, 0, 32, "from 0 to 32",
      "How many pictures of the body stand along the time axis."));
  fields.push_back(times(
      "plot.thumbnails_at_s", [](Options& o) -> std::vector<double>& { return o.plot.thumbnails_at_s; },
      "a list of at most 64 times of 0 s or more", "At which times they stand; empty: evenly spread."));
  return fields;
}

}  // namespace

const std::vector<Field>& schema() {
  static const auto fields = make_schema();
  return fields;
}

}  // namespace choreo::config
