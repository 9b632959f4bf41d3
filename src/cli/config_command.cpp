// SPDX-License-Identifier: Apache-2.0
// choreoscope config: every setting with its origin, and whether a file is right.
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "cli/commands.hpp"
#include "config/config.hpp"

namespace choreo::cli {
namespace {

struct ConfigOptions {
  std::string file;
  std::vector<std::string> assignments;
};

config::Config load(const ConfigOptions& options) {
  config::Config config;
  if (!options.file.empty()) config.load_file(options.file);
  for (const auto& assignment : options.assignments) config.set(assignment);
  return config;
}

}  // namespace

void declare_config(CLI::App& app, Command& chosen) {
  auto* command = app.add_subcommand("config", "show every setting with its origin, or check a file");
  command->require_subcommand(1);

  auto show = std::make_shared<ConfigOptions>();
  auto* show_command = command->add_subcommand("show", "print every setting: meaning, range, value, origin; as TOML");
  show_command->add_option("--config", show->file, "settings from a TOML file")->type_name("FILE");
  show_command->add_option("--set", show->assignments, "one setting; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  show_command->callback([show, &chosen] {
    chosen = [show](Session&) {
      fmt::print("{}", load(*show).show());
      return kDone;
    };
  });

  auto check = std::make_shared<ConfigOptions>();
  auto* check_command = command->add_subcommand("check", "say whether a configuration file is right");
  check_command->add_option("FILE", check->file, "a TOML file")->required();
  check_command->callback([check, &chosen] {
    chosen = [check](Session&) {
      (void)load(*check);
      fmt::print("{}: ok\n", check->file);
      return kDone;
    };
  });
}

}  // namespace choreo::cli
