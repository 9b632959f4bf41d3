// SPDX-License-Identifier: Apache-2.0
#include "cli/memory.hpp"

#include <fstream>
#include <string>

namespace choreo::cli {

std::optional<std::uint64_t> available_memory() {
  std::ifstream file("/proc/meminfo");
  std::string key;
  std::uint64_t kibibytes = 0;
  for (std::string rest; file >> key >> kibibytes; std::getline(file, rest)) {
    if (key == "MemAvailable:") return kibibytes * 1024;
  }
  return std::nullopt;
}

}  // namespace choreo::cli
