// SPDX-License-Identifier: Apache-2.0
#include "devices/openni2/openni2_recording.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/text.hpp"
#include "devices/openni2/openni2_session.hpp"

namespace choreo::devices::openni2 {
namespace {

constexpr std::string_view kRecordingMagic = "NI10";
constexpr Nanoseconds kSlice = std::chrono::milliseconds(50);  // How late a request to stop is seen.

// Without waiting, should it be a pipe.
Descriptor opened(const std::string& path) {
  return Descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
}

bool is_plain_file(const Descriptor& file) {
  struct stat what {};
  return ::fstat(file.number(), &what) == 0 && S_ISREG(what.st_mode);
}

bool begins_as_recording(const Descriptor& file) {
  std::array<char, kRecordingMagic.size()> begin{};
  return ::pread(file.number(), begin.data(), begin.size(), 0) == static_cast<ssize_t>(begin.size()) &&
         std::string_view(begin.data(), begin.size()) == kRecordingMagic;
}

Descriptor checked(const std::string& path) {
  auto file = opened(path);
  if (file.number() < 0) {
    throw usage_error(fmt::format("\"{}\" cannot be read: {}", path, std::generic_category().message(errno)));
  }
  if (!is_plain_file(file))
    throw usage_error(fmt::format("\"{}\" is no file", path), {}, "an .oni recording is a file");
  if (!begins_as_recording(file)) {
    throw usage_error(fmt::format("\"{}\" is no recording of OpenNI2", path), {},
                      "an .oni file begins with the letters NI10");
  }
  return file;
}

}  // namespace

bool is_recording(const std::string& path) {
  const auto file = opened(path);
  return file.number() >= 0 && is_plain_file(file) && begins_as_recording(file);
}

Recording::Recording(const SourceUri& uri, const Request& request, const OpenOptions& options, Nanoseconds patience)
    : path_(uri.location), patience_(patience), maker_(options.keep_raw) {
  const auto file = checked(path_);
  try {
    connection_.emplace(request, file, patience, options.stop);
  } catch (const Refusal& refusal) {
    if (refusal.trouble().kind != TroubleKind::kDamaged) throw_refusal(refusal, path_);
    throw usage_error(fmt::format("\"{}\" is damaged: {}", path_, refusal.what()), {}, refusal.trouble().hint);
  } catch (const HelperGone& gone) {
    throw usage_error(fmt::format("\"{}\" is damaged: {}", path_, gone.what()));
  }
  const auto& leader = connection_->leader();
  const auto frames = connection_->opened().frames;
  info_.name = uri.text;
  info_.size = {static_cast<int>(leader.width), static_cast<int>(leader.height)};
  info_.nominal_fps = leader.fps;
  info_.repeatable = true;
  info_.depth = connection_->has_depth();
  if (frames > 0 && leader.fps > 0) info_.duration = from_seconds(double(frames) / leader.fps);
  // Only decoding tells whether there is a frame.
  first_ = next(options.stop);
  if (!first_ && options.stop.stop_requested()) throw failure(fmt::format("\"{}\": opening was interrupted", path_));
  if (!first_ && !broken_.empty()) throw usage_error(fmt::format("\"{}\" is damaged: {}", path_, broken_));
  if (!first_) {
    throw usage_error(fmt::format("\"{}\" holds no frame that can be decoded", path_), {},
                      "the recording was cut off or never begun");
  }
}

FramePtr Recording::read(std::stop_token stop) {
  if (stop.stop_requested()) return nullptr;
  return first_ ? std::exchange(first_, nullptr) : next(stop);
}

FramePtr Recording::next(const std::stop_token& stop) {
  Nanoseconds silent{0};
  while (!stop.stop_requested()) {
    while (auto moment = connection_->next()) {
      if (auto frame = frame_of(*moment)) return frame;
    }
    if (heard_all_) return nullptr;
    try {
      const auto heard = connection_->hear(kSlice);
      heard_all_ = heard == Connection::Heard::kEnd;
      silent = heard == Connection::Heard::kNothing ? silent + kSlice : Nanoseconds{0};
      if (silent >= patience_) broken_ = fmt::format("OpenNI2 was silent for {:.1f} s", to_seconds(silent));
    } catch (const Refusal& refusal) {
      broken_ = refusal.what();
    } catch (const HelperGone& gone) {
      broken_ = gone.what();
    }
    if (!broken_.empty()) {
      heard_all_ = true;
      connection_->end();
    }
    for (auto& line : connection_->take_warnings()) warnings_.push_back(std::move(line));
  }
  return nullptr;
}

FramePtr Recording::frame_of(const Moment& moment) {
  const auto& leader = moment.leader();
  auto frame = std::make_shared<Frame>();
  try {
    auto pictures = maker_.make(moment);
    frame->bgr = std::move(pictures.bgr);
    frame->depth = std::move(pictures.depth);
    frame->raw_colour = std::move(pictures.raw_colour);
    frame->raw_depth = std::move(pictures.raw_depth);
  } catch (const Error&) {
    ++damaged_;
    return nullptr;
  }
  frame->sequence = counter_.next(leader.index);
  frame->device_time = std::chrono::microseconds(leader.time_us);
  if (last_time_ && frame->device_time <= *last_time_) {
    ++mended_;
    frame->device_time = *last_time_ + Nanoseconds{1};
  }
  last_time_ = frame->device_time;
  ++delivered_;
  return frame;
}

std::vector<std::string> Recording::warnings() const {
  auto all = warnings_;
  if (damaged_ > 0) {
    all.push_back(
        fmt::format("\"{}\": {} damaged {} left out", path_, damaged_, damaged_ == 1 ? "frame was" : "frames were"));
  }
  if (mended_ > 0) {
    all.push_back(
        fmt::format("\"{}\": {} of {} time stamps did not increase, and were mended", path_, mended_, delivered_));
  }
  if (const auto unpaired = connection_->unpaired_depths(); unpaired > 0) {
    all.push_back(fmt::format("\"{}\": {} depth {} with no picture of the same time {} left out", path_, unpaired,
                              unpaired == 1 ? "frame" : "frames", unpaired == 1 ? "was" : "were"));
  }
  const auto declared = connection_->opened().frames;
  if (!broken_.empty()) {
    all.push_back(fmt::format("\"{}\" ends after {}: {}", path_, counted(delivered_, "frame"), broken_));
  } else if (heard_all_ && delivered_ + damaged_ < declared) {
    all.push_back(
        fmt::format("\"{}\" ends after {} of the {} frames it declares: truncated?", path_, delivered_, declared));
  }
  return all;
}

}  // namespace choreo::devices::openni2
