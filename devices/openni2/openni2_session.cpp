// SPDX-License-Identifier: Apache-2.0
#include "devices/openni2/openni2_session.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "core/error.hpp"

namespace choreo::devices::openni2 {
namespace {

constexpr std::uint32_t kMostAtOnce = 4 * kSlots;  // Messages: a helper that never stops talking is not waited for.

}  // namespace

void throw_refusal(const Refusal& refusal, const std::string& where) {
  const auto& trouble = refusal.trouble();
  if (trouble.kind == TroubleKind::kLost) throw DeviceLost(trouble.text);
  throw usage_error(trouble.text, where, trouble.hint);
}

Session::Session(const Request& request, const std::string& name, bool keep_raw, const Clock& clock,
                 Nanoseconds patience, const std::stop_token& stop, bool every_frame)
    : clock_(clock), name_(name), maker_(keep_raw), every_frame_(every_frame) {
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
  info_.depth = connection_->has_depth();
}

// @return whether anything was heard.
bool Session::hear(Nanoseconds patience) {
  const auto heard = connection_->hear(std::max(patience, Nanoseconds{0}));
  if (heard == Connection::Heard::kEnd) throw DeviceLost("the device ended its stream");
  return heard == Connection::Heard::kSomething;
}

std::optional<Moment> Session::next(Nanoseconds patience) {
  const auto until = clock_.now() + patience;
  if (!every_frame_) {
    const auto before = connection_->pictures();
    for (std::uint32_t k = 0; k < kMostAtOnce && hear(Nanoseconds{0}); ++k) continue;
    if (connection_->pictures() - before >= kSlots) connection_->forget();
  }
  for (;;) {
    auto found = connection_->next();
    while (found && !every_frame_) {
      auto newer = connection_->next();
      if (!newer) break;
      found = std::move(newer);
    }
    const auto left = until - clock_.now();
    if (found || left <= Nanoseconds{0}) return found;
    (void)hear(left);
  }
}

std::optional<DeviceFrame> Session::wait(Nanoseconds patience) {
  watch_->begin(clock_.now());
  std::optional<Moment> moment;
  try {
    moment = next(patience);
  } catch (const Refusal& refusal) {
    throw DeviceLost(refusal.what());
  } catch (const HelperGone& gone) {
    throw DeviceLost(gone.what());
  }
  const auto now = clock_.now();
  for (std::size_t k = 0; k < connection_->opened().streams.size(); ++k)
    watch_->heard(k, connection_->pictures(k), now);
  watch_->end(now);
  if (!moment || !watch_->complete()) return std::nullopt;
  DeviceFrame frame;
  frame.arrival = clock_.now();
  frame.counter = moment->leader().index;
  frame.device_time = std::chrono::microseconds(moment->leader().time_us);
  try {
    auto pictures = maker_.make(*moment);
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
