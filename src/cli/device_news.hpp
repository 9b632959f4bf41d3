// SPDX-License-Identifier: Apache-2.0
// Tells the user what becomes of a device: on the console, and in the window where there is one.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "cli/call_slot.hpp"
#include "cli/console.hpp"
#include "devices/device_state.hpp"

namespace choreo::cli {

/// @thread thread-safe
class DeviceNews {
 public:
  explicit DeviceNews(Console& console) : console_(console) {}

  /// Says one line where the device is lost and one where it is back.
  void hear(const std::string& name, const devices::DeviceEvent& event);

  /// Whom to give the lines that stand in the window while the device is lost. Called until the guard that is returned
  /// goes away.
  using Show = std::function<void(std::vector<std::string>)>;
  [[nodiscard]] std::shared_ptr<void> show_with(Show show);

 private:
  Console& console_;
  CallSlot<std::vector<std::string>> show_;
  std::mutex mutex_;
  std::optional<Nanoseconds> lost_at_;
};

}  // namespace choreo::cli
