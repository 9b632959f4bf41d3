// SPDX-License-Identifier: Apache-2.0
#include "config/text_file.hpp"

#include <fstream>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "core/error.hpp"

namespace choreo::config {

std::string read_text_file(const std::filesystem::path& path, std::uintmax_t most, const std::string& what) {
  const auto name = path.string();
  std::error_code problem;
  const auto status = std::filesystem::status(path, problem);
  if (name.find('\0') != std::string::npos || status.type() == std::filesystem::file_type::not_found) {
    throw usage_error(fmt::format("no such {}", what), name);
  }
  if (std::filesystem::is_directory(status)) throw usage_error(fmt::format("is a folder, not a {}", what), name);
  std::ifstream file(path, std::ios::binary);
  if (!file) throw usage_error(fmt::format("the {} cannot be read", what), name);
  std::string text;
  // Read, not asked for: a pipe has no size.
  std::vector<char> buffer(1U << 16);
  while (file && text.size() <= most) {
    file.read(buffer.data(), std::streamsize(buffer.size()));
    text.append(buffer.data(), std::size_t(file.gcount()));
  }
  if (file.bad()) throw usage_error(fmt::format("the {} cannot be read", what), name);
  if (text.size() > most) {
    throw usage_error(fmt::format("is larger than {} MiB: no {}", most >> 20U, what), name);
  }
  return text;
}

}  // namespace choreo::config
