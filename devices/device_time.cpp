// SPDX-License-Identifier: Apache-2.0
#include "devices/device_time.hpp"

#include <algorithm>

namespace choreo::devices {

Nanoseconds DeviceClock::host_time(Nanoseconds device, Nanoseconds arrival) {
  const auto difference = arrival - device;
  if (of_host_ && difference >= Nanoseconds{0} && difference <= kOldest) {
    offset_ = Nanoseconds{0};
  } else if (offset_) {
    const auto passed = std::max(Nanoseconds{0}, arrival - last_arrival_);
    // Arrivals may be late by any time; the device's own clock goes on as the host's does.
    const auto unexplained = (device - last_device_) - passed;
    const bool jumped = device < last_device_ || unexplained > kJump;
    const auto relaxed =
        *offset_ + Nanoseconds{static_cast<Nanoseconds::rep>(kMostDrift * static_cast<double>(passed.count()))};
    offset_ = jumped ? difference : std::min(relaxed, difference);
  } else {
    offset_ = difference;
  }
  last_device_ = device;
  last_arrival_ = arrival;
  auto host = device + *offset_;
  if (last_ && host <= *last_) host = *last_ + Nanoseconds{1};
  last_ = host;
  return host;
}

std::uint64_t FrameCounter::next(std::uint32_t counter) {
  if (last_) {
    const std::uint32_t ahead = counter - *last_;  // Modulo 2^32: a wrap is a step like any other.
    if (reopened_) {
      number_ += 2;
    } else {
      number_ += ahead >= 1 && ahead <= kMostLost ? ahead : 1;
    }
  }
  reopened_ = false;
  last_ = counter;
  return number_;
}

}  // namespace choreo::devices
