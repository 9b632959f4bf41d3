// SPDX-License-Identifier: Apache-2.0
#include "devices/openni2/pairing.hpp"

#include <algorithm>
#include <utility>

namespace choreo::devices::openni2 {
namespace {

constexpr std::size_t kMostBehind = 3;    // Pictures of video that wait for their depth.
constexpr std::size_t kMostDepths = 32;   // Depths that wait for video, should that stream be silent.
constexpr std::uint64_t kUsualRate = 30;  // Where the streams declare none.

std::uint64_t distance(const Taken& a, const Taken& b) {
  return a.time_us > b.time_us ? a.time_us - b.time_us : b.time_us - a.time_us;
}

Taken take_front(std::deque<Taken>& queue) {
  auto front = std::move(queue.front());
  queue.pop_front();
  return front;
}

}  // namespace

Pairing::Pairing(const std::vector<Mode>& streams) : both_(streams.size() > 1) {
  std::uint64_t fps = 0;
  for (const auto& stream : streams) fps = std::max<std::uint64_t>(fps, stream.fps);
  period_us_ = 1000000 / (fps > 0 ? fps : kUsualRate);
}

void Pairing::add(Taken taken) {
  auto& queue = taken.mode.sensor == Sensor::kDepth ? depth_ : video_;
  queue.push_back(std::move(taken));
  if (both_ && depth_.size() > kMostDepths) drop_depth();
}

void Pairing::drop_depth() {
  depth_.pop_front();
  if (begun_ && !ended_) ++unpaired_;
}

void Pairing::clear() {
  video_.clear();
  depth_.clear();
}

// Whether no depth that is still to come can be nearer than those that are there.
bool Pairing::decided(const Taken& video) const {
  if (ended_ || video_.size() > kMostBehind) return true;
  if (depth_.empty()) return false;
  const auto& last = depth_.back();
  return last.time_us >= video.time_us || distance(last, video) <= period_us_ / 4;
}

std::optional<Taken> Pairing::depth_of(const Taken& video) {
  const auto tolerance = period_us_ / 2;
  while (!depth_.empty() && depth_.front().time_us + tolerance < video.time_us) drop_depth();
  while (depth_.size() > 1 && distance(depth_[1], video) <= distance(depth_[0], video)) drop_depth();
  if (depth_.empty() || distance(depth_.front(), video) > tolerance) return std::nullopt;
  return take_front(depth_);
}

std::optional<Moment> Pairing::next() {
  Moment moment;
  if (!both_) {
    if (!video_.empty()) {
      moment.video = take_front(video_);
    } else if (!depth_.empty()) {
      moment.depth = take_front(depth_);
    } else {
      return std::nullopt;
    }
    return moment;
  }
  if (video_.empty() || !decided(video_.front())) return std::nullopt;
  moment.video = take_front(video_);
  moment.depth = depth_of(*moment.video);
  begun_ = true;
  return moment;
}

}  // namespace choreo::devices::openni2
