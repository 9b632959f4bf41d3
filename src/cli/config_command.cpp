// SPDX-License-Identifier: Apache-2.0
// choreoscope config: every setting with its origin, and whether a file is right.
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "cli/commands.hpp"
#include "cli/presets.hpp"
#include "config/config.hpp"

namespace choreo::cli {
namespace {

constexpr auto kExamples = R"(
Examples:
  choreoscope config show > my.toml
  choreoscope config check my.toml
  choreoscope config show --config my.toml --set mask.threshold=18)";

constexpr auto kShowExamples = R"(
What it prints is a configuration file with every setting in it, each with its
unit, its range, and where its value comes from.

Examples:
  choreoscope config show > my.toml
  choreoscope config show --config stage --set mask.threshold=18)";

constexpr auto kCheckExamples = R"(
Exit status 0 where it is right, else 2 and the line and column of the mistake.

Example:
  choreoscope config check my.toml)";

struct ConfigOptions {
  std::vector<std::string> files;
  std::vector<std::string> assignments;
};

config::Config load(const ConfigOptions& options) {
  config::Config config;
  for (const auto& file : options.files) config.load_file(find_configuration(file));
  for (const auto& assignment : options.assignments) config.set(assignment);
  return config;
}

}  // namespace

void declare_config(CLI::App& app, Command& chosen) {
  auto* command = app.add_subcommand("config", "show every setting with its origin, or check a file");
  command->require_subcommand(1);
  command->footer(kExamples);

  auto show = std::make_shared<ConfigOptions>();
  auto* show_command = command->add_subcommand("show", "print every setting: meaning, range, value, origin; as TOML");
  show_command->add_option("--config", show->files, "settings from a TOML file or a preset; may be repeated")
      ->type_name("FILE")
      ->allow_extra_args(false);
  show_command->add_option("--set", show->assignments, "one setting; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  show_command->callback([show, &chosen] {
    chosen = [show](Session&) {
      fmt::print("{}", load(*show).show());
      return kDone;
    };
  });

  show_command->footer(kShowExamples);

  auto check = std::make_shared<ConfigOptions>();
  auto* check_command = command->add_subcommand("check", "say whether a configuration file is right");
  check_command->add_option("FILE", check->files.emplace_back(), "a TOML file")->required();
  check_command->footer(kCheckExamples);
  check_command->callback([check, &chosen] {
    chosen = [check](Session&) {
      (void)load(*check);
      fmt::print("{}: ok\n", check->files.front());
      return kDone;
    };
  });
}

}  // namespace choreo::cli
