// SPDX-License-Identifier: Apache-2.0
// What a device may be in, and how it is told.
#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "core/time.hpp"

namespace choreo::devices {

/// stopped -> starting -> running -> lost -> running, as often as it goes. A device is lost from the moment it is known
/// to be until its next frame is there, and also where its first one never comes; failed where it cannot be had at all.
/// Stopping leads back to stopped from everywhere.
enum class DeviceState { kStopped, kStarting, kRunning, kLost, kFailed };

[[nodiscard]] std::string_view name_of(DeviceState state);

/// One change of a device's state.
struct DeviceEvent {
  DeviceState state = DeviceState::kStopped;
  Nanoseconds at{0};  ///< On the host's monotonic clock.
  std::string why;    ///< One line; empty where the state says it all.
};

/// Called from the thread that reads the device; quick, and must not throw.
using OnDeviceEvent = std::function<void(const DeviceEvent&)>;

/// The device went away, or has to be opened anew. Taken up again by whoever supervises it.
class DeviceLost : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace choreo::devices
