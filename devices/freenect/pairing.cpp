// SPDX-License-Identifier: Apache-2.0
#include "devices/freenect/pairing.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace choreo::devices::freenect {
namespace {

// 60 MHz: 50 ns are 3 ticks.
constexpr Nanoseconds of_ticks(std::int64_t ticks) { return Nanoseconds{ticks * 50 / 3}; }

constexpr double kFps = 30;

// What the ticks say has passed; nothing where that is not what has passed on the host.
std::optional<Nanoseconds> passed_by(std::uint32_t ticks, std::uint32_t since, Nanoseconds passed) {
  const auto told = of_ticks(ticks - since);
  if (told <= Nanoseconds{0} || std::chrono::abs(told - passed) > TickClock::kMostOff) return std::nullopt;
  return told;
}

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
  fill(colour, bytes, ticks, next_number(ticks, arrival), arrival);
  last_ticks_ = ticks;
  last_number_ = colour.counter;
  last_arrival_ = arrival;
  colour_waits_ = colour_came_ = true;
  if (with_depth_ && depth_came_ && ++alone_ > kPatience && !by_arrival_) by_arrival_ = true;
  return complete();
}

bool Pairing::add_depth(const void* bytes, std::uint32_t ticks, Nanoseconds arrival) noexcept {
  fill(depth, bytes, ticks, 0, arrival);
  depth_waits_ = depth_came_ = true;
  return complete();
}

// A picture that is lost on the way is called back for by nobody: only its time is missing.
std::uint32_t Pairing::next_number(std::uint32_t ticks, Nanoseconds arrival) const noexcept {
  if (!colour_came_) return 0;
  const auto passed = passed_by(ticks, last_ticks_, arrival - last_arrival_);
  const auto frames = passed ? std::lround(to_seconds(*passed) * kFps) : 1;
  return last_number_ + static_cast<std::uint32_t>(std::max(frames, 1L));
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

PairQueue::PairQueue(std::size_t places, std::size_t colour_bytes, std::size_t depth_bytes) : pairs_(places) {
  for (auto& pair : pairs_) {
    pair.colour.bytes.resize(colour_bytes);
    pair.depth.bytes.resize(depth_bytes);
  }
}

void PairQueue::put(Shot& colour, Shot& depth) noexcept {
  if (waiting_ == pairs_.size()) {
    first_ = (first_ + 1) % pairs_.size();
    --waiting_;
  }
  auto& place = pairs_[(first_ + waiting_++) % pairs_.size()];
  std::swap(place.colour, colour);
  std::swap(place.depth, depth);
}

bool PairQueue::take(Shot& colour, Shot& depth) noexcept {
  if (empty()) return false;
  std::swap(colour, pairs_[first_].colour);
  std::swap(depth, pairs_[first_].depth);
  first_ = (first_ + 1) % pairs_.size();
  --waiting_;
  return true;
}

Nanoseconds TickClock::time(std::uint32_t ticks, Nanoseconds arrival) {
  if (time_) {
    const auto passed = arrival - arrival_;
    *time_ += passed_by(ticks, ticks_, passed).value_or(passed);
  } else {
    time_ = Nanoseconds{0};
  }
  ticks_ = ticks;
  arrival_ = arrival;
  return *time_;
}

}  // namespace choreo::devices::freenect
