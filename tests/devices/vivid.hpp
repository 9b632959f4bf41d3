// SPDX-License-Identifier: Apache-2.0
// Finds the kernel's virtual camera.
#pragma once

#include <exception>
#include <string>

#include "devices/v4l2/v4l2_node.hpp"

namespace choreo::devices {

/// @return empty where there is none.
inline std::string vivid_path() {
  for (const auto& path : v4l2::video_nodes()) {
    try {
      const auto identity = v4l2::identity_of(v4l2::Node(path));
      if (identity && identity->driver == "vivid") return path;
    } catch (const std::exception&) {
      continue;
    }
  }
  return {};
}

}  // namespace choreo::devices
