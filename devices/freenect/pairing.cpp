// SPDX-License-Identifier: Apache-2.0
#include "devices/freenect/pairing.hpp"

#include <cstring>
#include <utility>

namespace choreo::devices::freenect {
namespace {

// 60 MHz: 50 ns are 3 ticks.
constexpr Nanoseconds of_ticks(std::int64_t ticks) { return Nanoseconds{ticks * 50 / 3}; }

void fill(Shot& shot, const void* bytes, std::uint32_t ticks, std::uint32_t counter, Nanoseconds arrival) noexcept {
  std::memcpy(shot.bytes.data(), bytes, shot.bytes.size());
  shot.ticks = ticks;
  shot.counter = counter;
  shot.arrival = arrival;
}

}  // namespace

Pairing::Pairing(std::size_t colour_bytes, std::size_t depth_bytes) : with_depth_(depth_bytes > 0) {
  colour.bytes.resize(colour_bytes);
  depth.bytes.resize(depth_bytes);
}

bool Pairing::add_colour(const void* bytes, std::uint32_t ticks, Nanoseconds arrival) noexcept {
  fill(colour, bytes, ticks, colours_++, arrival);
  colour_waits_ = true;
  if (with_depth_ && depths_ > 0 && ++alone_ > kPatience && !by_arrival_) by_arrival_ = true;
  return complete();
}

bool Pairing::add_depth(const void* bytes, std::uint32_t ticks, Nanoseconds arrival) noexcept {
  fill(depth, bytes, ticks, depths_++, arrival);
  depth_waits_ = true;
  return complete();
}

bool Pairing::complete() noexcept {
  if (!with_depth_) return std::exchange(colour_waits_, false);
  if (!colour_waits_ || !depth_waits_) return false;
  // Modulo 2^32, so that a wrap between the two does no harm.
  const auto later =
      by_arrival_ ? colour.arrival - depth.arrival : of_ticks(static_cast<std::int32_t>(colour.ticks - depth.ticks));
  if (std::chrono::abs(later) > kWithin) {
    // What comes next is later still: the older of the two stays alone.
    (later > Nanoseconds{0} ? depth_waits_ : colour_waits_) = false;
    return false;
  }
  colour_waits_ = depth_waits_ = false;
  alone_ = 0;
  return true;
}

Nanoseconds TickClock::time(std::uint32_t ticks, Nanoseconds arrival) {
  if (time_) {
    const auto passed = arrival - arrival_;
    const auto told = of_ticks(ticks - ticks_);
    const bool plausible = told > Nanoseconds{0} && std::chrono::abs(told - passed) <= kMostOff;
    *time_ += plausible ? told : passed;
  } else {
    time_ = Nanoseconds{0};
  }
  ticks_ = ticks;
  arrival_ = arrival;
  return *time_;
}

}  // namespace choreo::devices::freenect
