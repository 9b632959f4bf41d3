// SPDX-License-Identifier: Apache-2.0
// Streams from a device of OpenNI2, by way of the helper.
#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "devices/device_source.hpp"
#include "devices/openni2/connection.hpp"
#include "devices/openni2/stream_watch.hpp"

namespace choreo::devices::openni2 {

/// What the helper would not do, as an exception for whoever asked.
/// @throws DeviceLost for a device that is not there; else Error (usage).
[[noreturn]] void throw_refusal(const Refusal& refusal, const std::string& where);

class Session final : public DeviceSession {
 public:
  /// @param patience  how long OpenNI2 may stay silent while it opens the device.
  /// @param every_frame  as OpenOptions.
  /// @throws DeviceLost; Error (usage).
  Session(const Request& request, const std::string& name, bool keep_raw, const Clock& clock, Nanoseconds patience,
          const std::stop_token& stop, bool every_frame = false);

  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  /// OpenNI2 counts microseconds from when it pleases.
  [[nodiscard]] bool stamps_with_host_clock() const override { return false; }
  /// With every_frame the oldest moment that waits; there is room for kSlots pictures. Else the newest; the numbers of
  /// older ones that waited are missing. Where pictures waited in every place there is, those that came since found
  /// none, and a new one is waited for. The first one comes when every stream has begun.
  /// @throws DeviceLost also where one of two streams is silent for as long as DeviceSource lets a device be.
  [[nodiscard]] std::optional<DeviceFrame> wait(Nanoseconds patience) override;
  [[nodiscard]] std::vector<std::string> take_warnings() override;

  /// The device that was opened.
  [[nodiscard]] const DeviceFound& device() const { return connection_->opened().device; }
  [[nodiscard]] pid_t helper() { return connection_->helper().process(); }

 private:
  [[nodiscard]] bool hear(Nanoseconds patience);
  [[nodiscard]] std::optional<Moment> next(Nanoseconds patience);

  const Clock& clock_;
  std::string name_;
  SourceInfo info_;
  std::optional<Connection> connection_;
  std::optional<StreamWatch> watch_;
  FrameMaker maker_;
  bool every_frame_;
  std::vector<std::string> warnings_;
};

}  // namespace choreo::devices::openni2
