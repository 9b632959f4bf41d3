// SPDX-License-Identifier: Apache-2.0
#include "devices/openni2/stream_watch.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace choreo::devices::openni2 {
namespace {

constexpr double kUsualFps = 30;  // Where a stream declares none.

}  // namespace

std::string name_of(Sensor sensor) {
  constexpr std::array kNames = {"", "infrared", "colour", "depth"};
  return kNames[static_cast<std::size_t>(sensor)];
}

StreamWatch::StreamWatch(const std::vector<Mode>& streams, Nanoseconds now, const DeviceOptions& limits)
    : limits_(limits) {
  for (const auto& mode : streams) streams_.push_back({mode, 0, now});
}

void StreamWatch::begin(Nanoseconds now) {
  if (!left_at_) return;
  for (auto& stream : streams_) stream.last_heard += now - *left_at_;
}

void StreamWatch::heard(std::size_t stream, std::uint64_t pictures, Nanoseconds now) {
  auto& it = streams_[stream];
  if (pictures == it.pictures) return;
  it.pictures = pictures;
  it.last_heard = now;
}

Nanoseconds StreamWatch::longest_silence(const Stream& stream) const {
  if (stream.pictures == 0) return limits_.first_frame;
  const double fps = stream.mode.fps > 0 ? stream.mode.fps : kUsualFps;
  return std::clamp(from_seconds(limits_.silent_frames / fps), limits_.least_silence, limits_.most_silence);
}

void StreamWatch::end(Nanoseconds now) {
  left_at_ = now;
  Nanoseconds newest{0};
  for (const auto& stream : streams_) newest = std::max(newest, stream.last_heard);
  for (const auto& stream : streams_) {
    const auto silence = newest - stream.last_heard;
    if (silence <= longest_silence(stream)) continue;
    throw DeviceLost(fmt::format("the {} stream is silent: no picture for {:.1f} s, though there are others",
                                 name_of(stream.mode.sensor), to_seconds(silence)));
  }
}

bool StreamWatch::complete() const {
  return std::all_of(streams_.begin(), streams_.end(), [](const Stream& stream) { return stream.pictures > 0; });
}

}  // namespace choreo::devices::openni2
