// SPDX-License-Identifier: Apache-2.0
#include "devices/openni2/openni2_session.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "core/error.hpp"

namespace choreo::devices::openni2 {

void throw_refusal(const Refusal& refusal, const std::string& where) {
  const auto& trouble = refusal.trouble();
  if (trouble.kind == TroubleKind::kLost) throw DeviceLost(trouble.text);
  throw usage_error(trouble.text, where, trouble.hint);
}

Session::Session(const Request& request, const std::string& name, bool keep_raw, const Clock& clock,
                 Nanoseconds patience, const std::stop_token& stop)
    : clock_(clock), name_(name), maker_(keep_raw) {
  try {
    connection_.emplace(request, Descriptor(), patience, stop);
  } catch (const Refusal& refusal) {
    throw_refusal(refusal, {});
  } catch (const HelperGone& gone) {
    throw DeviceLost(gone.what());
  }
  watch_.emplace(connection_->opened().streams, clock_.now());
  const auto& leader = connection_->leader();
  info_.size = {static_cast<int>(leader.width), static_cast<int>(leader.height)};
  info_.nominal_fps = leader.fps;
}

std::optional<Moment> Session::hear(Nanoseconds patience) {
  const auto until = clock_.now() + patience;
  std::optional<Moment> newest;
  try {
    // What already waits is taken without waiting; only for the first moment there is patience.
    for (auto left = patience;; left = newest ? Nanoseconds{0} : until - clock_.now()) {
      const auto heard = connection_->hear(std::max(left, Nanoseconds{0}));
      while (auto moment = connection_->next()) newest = std::move(moment);
      if (heard == Connection::Heard::kEnd) throw DeviceLost("the device ended its stream");
      if (heard == Connection::Heard::kNothing && (newest || left <= Nanoseconds{0})) break;
    }
  } catch (const Refusal& refusal) {
    throw DeviceLost(refusal.what());
  } catch (const HelperGone& gone) {
    throw DeviceLost(gone.what());
  }
  return newest;
}

std::optional<DeviceFrame> Session::wait(Nanoseconds patience) {
  watch_->begin(clock_.now());
  const auto newest = hear(patience);
  const auto now = clock_.now();
  for (std::size_t k = 0; k < connection_->opened().streams.size(); ++k)
    watch_->heard(k, connection_->pictures(k), now);
  watch_->end(now);
  if (!newest || !watch_->complete()) return std::nullopt;
  DeviceFrame frame;
  frame.arrival = clock_.now();
  frame.counter = newest->leader().index;
  frame.device_time = std::chrono::microseconds(newest->leader().time_us);
  try {
    auto pictures = maker_.make(*newest);
    frame.bgr = std::move(pictures.bgr);
    frame.depth = std::move(pictures.depth);
    frame.raw_colour = std::move(pictures.raw_colour);
    frame.raw_depth = std::move(pictures.raw_depth);
  } catch (const Error&) {
    warnings_.push_back(fmt::format("{} gave damaged frames, which were left out", name_));
    return std::nullopt;
  }
  return frame;
}

std::vector<std::string> Session::take_warnings() {
  auto all = connection_->take_warnings();
  std::move(warnings_.begin(), warnings_.end(), std::back_inserter(all));
  warnings_.clear();
  return all;
}

}  // namespace choreo::devices::openni2
