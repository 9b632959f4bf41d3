// SPDX-License-Identifier: Apache-2.0
#include "cli/memory.hpp"

#include <algorithm>
#include <fstream>
#include <string>

namespace choreo::cli {
namespace {

// A file that holds one number; nothing where it is not there or says "max".
std::optional<std::uint64_t> number_in(const std::string& path) {
  std::ifstream file(path);
  std::uint64_t number = 0;
  return file >> number ? std::optional(number) : std::nullopt;
}

std::optional<std::uint64_t> left_in_group() {
  std::ifstream file("/proc/self/cgroup");
  std::string line;
  while (std::getline(file, line)) {
    if (!line.starts_with("0::")) continue;  // Version 2.
    const auto folder = "/sys/fs/cgroup" + line.substr(3) + "/";
    const auto most = number_in(folder + "memory.max");
    const auto now = number_in(folder + "memory.current");
    if (most && now) return *most - std::min(*most, *now);
  }
  return std::nullopt;
}

std::optional<std::uint64_t> available_in_system() {
  std::ifstream file("/proc/meminfo");
  std::string key;
  std::uint64_t kibibytes = 0;
  for (std::string rest; file >> key >> kibibytes; std::getline(file, rest)) {
    if (key == "MemAvailable:") return kibibytes * 1024;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::uint64_t> available_memory() {
  const auto system = available_in_system();
  const auto group = left_in_group();
  return system && group ? std::min(*system, *group) : system;
}

}  // namespace choreo::cli
