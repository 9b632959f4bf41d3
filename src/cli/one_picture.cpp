// SPDX-License-Identifier: Apache-2.0
#include "cli/one_picture.hpp"

#include <cmath>
#include <filesystem>

#include "devices/image_folder/numbered_names.hpp"

namespace choreo::cli {

bool is_one_picture(const devices::SourceInfo& source) {
  if (source.live) return false;
  if (source.numbered_pictures) {
    return source.duration && std::llround(to_seconds(*source.duration) * source.nominal_fps) == 1;
  }
  const auto path = source.name.substr(0, source.name.rfind('?'));
  return devices::is_picture_name(std::filesystem::path(path).filename().string());
}

}  // namespace choreo::cli
