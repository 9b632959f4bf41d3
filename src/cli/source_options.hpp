// SPDX-License-Identifier: Apache-2.0
// The options of every command that takes a SOURCE.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/config.hpp"
#include "pipeline/frame_selection.hpp"

namespace CLI {
class App;
}

namespace choreo::cli {

struct SourceOptions {
  std::string source;
  std::vector<std::string> config_files;  ///< Of two that set the same, the later counts.
  std::vector<std::string> assignments;
  std::optional<std::string> background;  ///< Absent: as configured.
  std::optional<std::string> span;        ///< Absent: everything.
  long long every = 1;
  int threads = 0;

  /// Declares them on a command.
  void declare(CLI::App& command);

  /// @throws Error (usage)
  /// @param defaults  of this command where they are others than everybody's: key and TOML value.
  /// @param origin  what is said of where those come from.
  [[nodiscard]] config::Config configuration(const std::vector<std::pair<std::string, std::string>>& defaults = {},
                                             const std::string& origin = {}) const;
  [[nodiscard]] pipeline::FrameSelection selection() const;
};

}  // namespace choreo::cli
