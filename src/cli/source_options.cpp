// SPDX-License-Identifier: Apache-2.0
#include "cli/source_options.hpp"

#include <CLI/CLI.hpp>

#include "cli/presets.hpp"
#include "core/error.hpp"
#include "core/text.hpp"

namespace choreo::cli {
namespace {

// CLI11 reads no text at all as 0.
const CLI::Validator kNotEmpty([](const std::string& text) { return std::string(text.empty() ? "is empty" : ""); }, "");

}  // namespace

void SourceOptions::declare(CLI::App& command) {
  command
      .add_option("SOURCE", source,
                  "a video file or network address, a folder of numbered images (folder?fps=25), or\n"
                  "synthetic://SCRIPT?size=640x480&fps=30&seed=1&noise=3; all take rotate=90 and flip=horizontal")
      ->required();
  command
      .add_option("--config", config_files,
                  "settings from a TOML file, or a preset; may be repeated\n(presets: " + join(preset_names()) + ")")
      ->type_name("FILE")
      ->allow_extra_args(false);
  command.add_option("--set", assignments, "one setting; may be repeated (choreoscope config show lists them)")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  command
      .add_option("--background", background,
                  "auto: estimated over the whole clip (default); first:1s: median of the first second;\n"
                  "or the path of a picture of the empty room, of the frames' size")
      ->type_name("WHAT");
  command.add_option("--every", every, "take the first of each N frames (1 to 1000000, default 1)")
      ->type_name("N")
      ->check(kNotEmpty);
  command
      .add_option("--span", span,
                  "only the frames from A to B: seconds, half open (1.5:3), or the source's\n"
                  "frames counted from 1, both ends in (1f:468f)")
      ->type_name("A:B");
  command.add_option("--threads", threads, "threads to use (0 to 1024, default 0: one a core); never changes a result")
      ->type_name("N")
      ->check(kNotEmpty);
}

config::Config SourceOptions::configuration(const std::vector<std::pair<std::string, std::string>>& defaults,
                                            const std::string& origin) const {
  config::Config config;
  for (const auto& [key, value] : defaults) config.set(key + "=" + value, origin);
  for (const auto& file : config_files) config.load_file(find_configuration(file));
  for (const auto& assignment : assignments) config.set(assignment);
  if (background) config.set_text("background.from", *background, "--background");
  return config;
}

pipeline::FrameSelection SourceOptions::selection() const {
  pipeline::FrameSelection selection;
  if (span) selection = pipeline::parse_span(*span);
  if (every < 1 || every > 1'000'000) {
    throw usage_error("is " + std::to_string(every), "--every", "--every is a whole number from 1 to 1000000");
  }
  if (threads < 0 || threads > 1024) {
    throw usage_error("is " + std::to_string(threads), "--threads", "--threads is a whole number from 0 (all) to 1024");
  }
  selection.every = static_cast<std::uint64_t>(every);
  return selection;
}

}  // namespace choreo::cli
