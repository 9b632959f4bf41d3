// SPDX-License-Identifier: Apache-2.0
#include "devices/device_source.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "core/error.hpp"

namespace choreo::devices {
namespace {

constexpr Nanoseconds kSlice = std::chrono::milliseconds(50);  // How late a request to stop is seen.

}  // namespace

DeviceSource::DeviceSource(std::string name, OpenSession open, const Clock& clock, DeviceOptions options)
    : name_(std::move(name)), open_(std::move(open)), clock_(clock), options_(std::move(options)) {
  enter(DeviceState::kStarting);
  try {
    this->open(options_.stop);
  } catch (const DeviceLost& lost) {
    enter(DeviceState::kFailed, lost.what());
    throw usage_error(lost.what(), name_, "choreoscope devices lists what is there");
  } catch (const Error& error) {
    enter(DeviceState::kFailed, error.what());
    throw;
  }
  info_ = session_->info();
  info_.name = name_;
  info_.live = true;
  info_.repeatable = false;
  left_at_ = clock_.now();
}

DeviceSource::~DeviceSource() {
  session_.reset();
  enter(DeviceState::kStopped);
}

DeviceState DeviceSource::state() const {
  const std::scoped_lock lock(mutex_);
  return state_;
}

std::vector<std::string> DeviceSource::warnings() const {
  auto all = warnings_;
  if (left_out_warnings_ > 0) all.push_back(fmt::format("{}: {} more of the like", name_, left_out_warnings_));
  const bool away = state() == DeviceState::kLost;
  if (losses_ > 0) {
    all.push_back(fmt::format("{} was lost {} time{} {}", name_, losses_, losses_ == 1 ? "" : "s",
                              away ? "and is not back" : "and taken up again as soon as it was back"));
  } else if (away) {
    all.push_back(fmt::format("{} never gave a frame", name_));
  }
  if (const auto damaged = damaged_before_ + (session_ ? session_->damaged() : 0); damaged > 0) {
    all.push_back(fmt::format("{}: {} damaged frame{} left out", name_, damaged, damaged == 1 ? " was" : "s were"));
  }
  return all;
}

void DeviceSource::enter(DeviceState state, const std::string& why) {
  {
    const std::scoped_lock lock(mutex_);
    if (state_ == state) return;
    state_ = state;
  }
  if (options_.on_event) options_.on_event({state, clock_.now(), why});
}

// Once each: a device that is retried four times a second has the same to say each time. What has a number in it may
// differ each time, for days.
void DeviceSource::warn(std::string line) {
  constexpr std::size_t kMostWarnings = 100;
  if (std::find(warnings_.begin(), warnings_.end(), line) != warnings_.end()) return;
  if (warnings_.size() == kMostWarnings) {
    ++left_out_warnings_;
  } else {
    warnings_.push_back(std::move(line));
  }
}

void DeviceSource::open(const std::stop_token& stop) {
  session_ = open_(stop);
  device_clock_ = DeviceClock(session_->stamps_with_host_clock());
  last_heard_ = clock_.now();
  first_ = true;
}

void DeviceSource::lose(const std::string& why) {
  damaged_before_ += session_->damaged();
  const auto closing = std::exchange(session_, nullptr);  // Only when the loss was told: it may take seconds.
  pause_ = first_;
  if (state() == DeviceState::kRunning) ++losses_;
  enter(DeviceState::kLost, why);
}

bool DeviceSource::reopen(const std::stop_token& stop) {
  try {
    open(stop);
  } catch (const DeviceLost&) {
    return false;  // Still away.
  } catch (const Error& error) {
    if (stop.stop_requested()) return false;
    // What is there now is another camera, or one that has lost a mode: that may mend itself, too.
    warn(error.what());
    return false;
  }
  if (session_->info().size != info_.size) {
    warn(fmt::format("{} came back with pictures of {} x {} instead of {} x {}: not taken", name_,
                     session_->info().size.width, session_->info().size.height, info_.size.width, info_.size.height));
    session_.reset();
    return false;
  }
  counter_.reopened();
  return true;
}

Nanoseconds DeviceSource::longest_silence() const {
  if (first_) return options_.first_frame;
  const double fps = info_.nominal_fps > 0 ? info_.nominal_fps : 30;
  const auto most = std::max(options_.most_silence, from_seconds(options_.least_frames / fps));
  return std::clamp(from_seconds(options_.silent_frames / fps), options_.least_silence, most);
}

FramePtr DeviceSource::read(std::stop_token stop) {
  // Silence is the device's only while somebody listens.
  last_heard_ += clock_.now() - left_at_;
  auto frame = read_next(std::move(stop));
  left_at_ = clock_.now();
  return frame;
}

FramePtr DeviceSource::read_next(const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  while (!stop.stop_requested()) {
    if (!session_) {
      if (std::exchange(pause_, false)) {
        std::unique_lock lock(mutex);
        never.wait_for(lock, stop, options_.retry, [] { return false; });
      } else {
        pause_ = !reopen(stop);
      }
      continue;
    }
    std::optional<DeviceFrame> got;
    try {
      got = session_->wait(kSlice);
    } catch (const DeviceLost& lost) {
      lose(lost.what());
      continue;
    }
    for (auto& line : session_->take_warnings()) warn(std::move(line));
    const auto now = clock_.now();
    if (!got) {
      const auto silence = now - last_heard_;
      if (silence > longest_silence()) lose(fmt::format("no frame for {:.1f} s", to_seconds(silence)));
      continue;
    }
    last_heard_ = now;
    first_ = false;
    enter(DeviceState::kRunning);
    auto frame = std::make_shared<Frame>();
    frame->sequence = counter_.next(got->counter);
    frame->device_time = device_clock_.host_time(got->device_time, got->arrival);
    // Of two sessions the later one's clock may be off by as long as a frame took to arrive.
    if (last_time_ && frame->device_time <= *last_time_) frame->device_time = *last_time_ + Nanoseconds{1};
    last_time_ = frame->device_time;
    frame->bgr = std::move(got->bgr);
    frame->depth = std::move(got->depth);
    frame->raw_colour = std::move(got->raw_colour);
    frame->raw_depth = std::move(got->raw_depth);
    return frame;
  }
  return nullptr;
}

}  // namespace choreo::devices
