// SPDX-License-Identifier: Apache-2.0
// Brings a device's own time stamps and frame numbers to the host's clock and to one count without end.
#pragma once

#include <cstdint>
#include <optional>

#include "core/time.hpp"

namespace choreo::devices {

/// Maps the times of a device's clock to the host's monotonic clock.
///
/// A frame cannot arrive before it was made, and the quickest of many arrives nearly at once: the offset between the
/// clocks is the least difference (arrival - device time) seen. Two quartz clocks drift apart, by some 50 parts per
/// million: the least difference is forgotten at `kMostDrift` of the time that passes. A driver that stamps with the
/// host's own clock is believed, as long as its times lie within `kOldest` before their arrival. A device time that
/// jumps, such as a counter that wraps, begins anew at its arrival. Results are strictly increasing.
class DeviceClock {
 public:
  /// How much slower than the host's the device's clock may run, as a share.
  static constexpr double kMostDrift = 2e-4;
  /// A frame that waited longer than this was not stamped with the host's clock.
  static constexpr Nanoseconds kOldest = std::chrono::seconds(5);
  /// A difference that changes by more between two frames is a jump.
  static constexpr Nanoseconds kJump = std::chrono::seconds(1);

  /// @param of_host  whether the driver says that it stamps with the host's monotonic clock.
  explicit DeviceClock(bool of_host = false) : of_host_(of_host) {}

  /// @param device  the device's time stamp.  @param arrival  when the frame was handed over, on the host's clock.
  /// @return the device's time on the host's clock, never later than `arrival` but for the strict increase.
  [[nodiscard]] Nanoseconds host_time(Nanoseconds device, Nanoseconds arrival);

 private:
  bool of_host_;
  std::optional<Nanoseconds> offset_;  // Host minus device.
  Nanoseconds last_device_{0};
  Nanoseconds last_arrival_{0};
  std::optional<Nanoseconds> last_;
};

/// Continues a 32-bit frame counter that wraps, and that begins again when a device is opened anew.
class FrameCounter {
 public:
  /// A counter that seems to go back, or ahead by more than this, began anew.
  static constexpr std::uint32_t kMostLost = 1U << 20;

  /// @return a number that starts at 0 and increases by what the counter increased by.
  [[nodiscard]] std::uint64_t next(std::uint32_t counter);
  /// The device was opened anew: the next frame follows the last one, `lost` frames of unknown number between them
  /// count as one.
  void reopened() { reopened_ = true; }

 private:
  std::optional<std::uint32_t> last_;
  std::uint64_t number_ = 0;
  bool reopened_ = false;
};

}  // namespace choreo::devices
