// SPDX-License-Identifier: Apache-2.0
#include "devices/openni2/connection.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace choreo::devices::openni2 {
namespace {

constexpr Nanoseconds kSlice = std::chrono::milliseconds(50);  // How late a request to stop is seen.

[[noreturn]] void mad(std::string_view why) { throw HelperGone(fmt::format("OpenNI2's helper went mad: {}", why)); }

}  // namespace

Connection::Connection(const Request& request, const Descriptor& recording, Nanoseconds patience,
                       const std::stop_token& stop)
    : helper_(request, recording) {
  if (!std::holds_alternative<Hello>(message_within(patience, stop))) mad("it does not say hello");
  for (;;) {
    auto message = message_within(patience, stop);
    if (auto* warning = std::get_if<Warning>(&message)) {
      warnings_.push_back(std::move(warning->text));
    } else if (auto* opened = std::get_if<Opened>(&message)) {
      opened_ = std::move(*opened);
      break;
    } else if (auto* trouble = std::get_if<Trouble>(&message)) {
      throw Refusal(std::move(*trouble));
    } else {
      mad("it speaks out of turn");
    }
  }
  pairing_.emplace(opened_.streams);
  pictures_.resize(opened_.streams.size());
}

Message Connection::message_within(Nanoseconds patience, const std::stop_token& stop) {
  for (Nanoseconds waited{0}; waited < patience; waited += kSlice) {
    if (stop.stop_requested()) throw HelperGone("opening was interrupted");
    if (auto message = helper_.next(std::min(kSlice, patience))) return std::move(*message);
  }
  throw HelperGone(fmt::format("OpenNI2 hangs: nothing was heard for {:.1f} s", to_seconds(patience)));
}

bool Connection::has_depth() const {
  return std::any_of(opened_.streams.begin(), opened_.streams.end(),
                     [](const Mode& mode) { return mode.sensor == Sensor::kDepth; });
}

const Mode& Connection::leader() const {
  const auto& all = opened_.streams;
  const auto video =
      std::find_if(all.begin(), all.end(), [](const Mode& mode) { return mode.sensor != Sensor::kDepth; });
  return video != all.end() ? *video : all.front();
}

Connection::Heard Connection::hear(Nanoseconds patience) {
  auto message = helper_.next(patience);
  if (!message) return Heard::kNothing;
  if (const auto* picture = std::get_if<Picture>(&*message)) {
    take(*picture);
  } else if (auto* warning = std::get_if<Warning>(&*message)) {
    if (warnings_.size() < 100) warnings_.push_back(std::move(warning->text));
  } else if (auto* trouble = std::get_if<Trouble>(&*message)) {
    throw Refusal(std::move(*trouble));
  } else if (std::holds_alternative<End>(*message)) {
    pairing_->end();
    return Heard::kEnd;
  } else {
    mad("it speaks out of turn");
  }
  return Heard::kSomething;
}

void Connection::take(const Picture& picture) {
  const auto& all = opened_.streams;
  const auto stream = std::find(all.begin(), all.end(), picture.mode);
  if (stream == all.end()) mad("a picture is of no stream that is open");
  ++all_pictures_;
  ++pictures_[static_cast<std::size_t>(stream - all.begin())];
  const auto pixels = helper_.pixels(picture);
  pairing_->add({picture.mode, picture.index, picture.time_us, {pixels.begin(), pixels.end()}});
  helper_.release(picture);
}

}  // namespace choreo::devices::openni2
