// SPDX-License-Identifier: Apache-2.0
#include "cli/presets.hpp"

#include <algorithm>
#include <system_error>

#include "core/error.hpp"
#include "core/text.hpp"

namespace choreo::cli {
namespace {

namespace fs = std::filesystem;

// At the same place beside the installed program and the built one.
fs::path preset_folder() {
  std::error_code problem;
  return (fs::read_symlink("/proc/self/exe", problem).parent_path() / CHOREO_PRESETS_FROM_BIN).lexically_normal();
}

}  // namespace

std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  std::error_code problem;
  fs::directory_iterator entry(preset_folder(), problem);
  for (; !problem && entry != fs::directory_iterator(); entry.increment(problem)) {
    if (entry->path().extension() == ".toml") names.push_back(entry->path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

fs::path find_configuration(const std::string& name) {
  std::error_code problem;
  if (fs::status(name, problem).type() != fs::file_type::not_found) return name;
  const auto names = preset_names();
  if (std::find(names.begin(), names.end(), name) != names.end()) return preset_folder() / (name + ".toml");
  const auto known = names.empty() ? std::string() : "; presets: " + join(names);
  throw usage_error("no such configuration file", shortened(name), "give a TOML file" + known);
}

}  // namespace choreo::cli
