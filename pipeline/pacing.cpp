// SPDX-License-Identifier: Apache-2.0
#include "pipeline/pacing.hpp"

#include <memory>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "core/error.hpp"

namespace choreo::pipeline {

Pace parse_pace(std::string_view text) {
  if (text == "live") return Pace::kLive;
  if (text == "replay") return Pace::kReplay;
  if (text == "max") return Pace::kMax;
  throw usage_error(fmt::format("the pace \"{}\" is unknown", text), {}, "known: live, replay, max");
}

devices::FramePtr PacedSource::read(std::stop_token stop) {
  auto frame = recording_->read(stop);
  if (!frame) return nullptr;
  if (!origin_) origin_ = frame->device_time;
  if (selection_.before(frame->sequence + 1, frame->device_time - *origin_)) return frame;
  if (!offset_) offset_ = clock_.now() - frame->device_time;
  behind_ = clock_.now() - (frame->device_time + *offset_);
  if (!wait_(frame->device_time + *offset_, stop)) return nullptr;
  return frame;
}

std::vector<std::string> PacedSource::warnings() const {
  auto all = recording_->warnings();
  constexpr auto kNoticed = std::chrono::milliseconds(200);
  if (behind_ > kNoticed) {
    all.push_back(
        fmt::format("the recording fell behind its own pace: its last frame came {:.1f} s late", to_seconds(behind_)));
  }
  return all;
}

std::unique_ptr<devices::Source> at_pace(Pace pace, std::unique_ptr<devices::Source> source, const Clock& clock,
                                         WaitUntil wait, const FrameSelection& selection) {
  if (pace == Pace::kMax || source->info().live) return source;
  return std::make_unique<PacedSource>(std::move(source), clock, std::move(wait), selection);
}

}  // namespace choreo::pipeline
