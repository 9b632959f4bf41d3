// SPDX-License-Identifier: Apache-2.0
#include "devices/device_state.hpp"

namespace choreo::devices {

std::string_view name_of(DeviceState state) {
  switch (state) {
    case DeviceState::kStopped:
      return "stopped";
    case DeviceState::kStarting:
      return "starting";
    case DeviceState::kRunning:
      return "running";
    case DeviceState::kLost:
      return "lost";
    case DeviceState::kFailed:
      return "failed";
  }
  return "";
}

}  // namespace choreo::devices
