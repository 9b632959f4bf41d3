// SPDX-License-Identifier: Apache-2.0
#include "pipeline/model_file.hpp"

#include <filesystem>
#include <fstream>
#include <system_error>

#include <fmt/format.h>

#include "core/error.hpp"

namespace choreo::pipeline {

namespace fs = std::filesystem;

void require_model(const std::string& path, const std::string& hint) {
  std::error_code problem;
  const auto type = fs::status(path, problem).type();
  if (type == fs::file_type::not_found) throw usage_error(fmt::format("there is no \"{}\"", path), {}, hint);
  if (type != fs::file_type::regular) throw usage_error(fmt::format("\"{}\" is no file", path), {}, hint);
}

std::string bytes_of_model(const std::string& path, std::size_t most, const std::string& what,
                           const std::string& hint) {
  require_model(path, hint);
  std::error_code problem;
  const auto size = fs::file_size(path, problem);
  if (!problem && size > most) throw usage_error(fmt::format("\"{}\" is too large for {}", path, what), {}, hint);
  std::ifstream file(path, std::ios::binary);
  std::string bytes(problem ? 0 : std::size_t(size), '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (problem || !file || std::size_t(file.gcount()) != bytes.size()) {
    throw usage_error(fmt::format("\"{}\" cannot be read", path), {}, hint);
  }
  return bytes;
}

}  // namespace choreo::pipeline
