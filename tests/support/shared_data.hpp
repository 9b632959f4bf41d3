// SPDX-License-Identifier: Apache-2.0
// Where the recordings of people lie that are not part of this repository.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include "support/places.hpp"

namespace choreo::test {

/// The path of `name` below the environment variable CHOREO_SHARED_DATA, or ../shared/data beside the project; empty
/// where it is not there, and the test then skips.
inline std::string shared_data(const std::string& name) {
  const char* given = std::getenv("CHOREO_SHARED_DATA");
  const auto root =
      given != nullptr ? std::filesystem::path(given) : std::filesystem::path(project_file("../shared/data"));
  const auto path = root / name;
  return std::filesystem::exists(path) ? path.string() : std::string();
}

}  // namespace choreo::test
