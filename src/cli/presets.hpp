// SPDX-License-Identifier: Apache-2.0
// Ready-made configurations, called by name.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace choreo::cli {

/// The names of the presets that came with the program, sorted; none where their folder is missing.
[[nodiscard]] std::vector<std::string> preset_names();

/// The file that `--config` means: a path, or the name of a preset where there is no file of that name.
/// @throws Error (usage) where it is neither, naming the presets.
[[nodiscard]] std::filesystem::path find_configuration(const std::string& name);

}  // namespace choreo::cli
