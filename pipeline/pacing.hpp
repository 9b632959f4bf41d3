// SPDX-License-Identifier: Apache-2.0
// A recording played as if it were a camera.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "core/time.hpp"
#include "devices/source.hpp"
#include "pipeline/frame_selection.hpp"

namespace choreo::pipeline {

/// How fast frames come, and what happens where they come faster than they are worked on.
enum class Pace {
  kLive,    ///< At their own time; the newest frame wins, and what it overtakes is counted as dropped.
  kReplay,  ///< At their own time at the earliest; the reader waits, no frame is lost.
  kMax,     ///< As fast as they can be worked on; no frame is lost.
};

/// @throws Error (usage) where the text is not "live", "replay" or "max".
[[nodiscard]] Pace parse_pace(std::string_view text);

/// Sleeps until a moment of the clock. @return false where `stop` was requested before.
using WaitUntil = std::function<bool(Nanoseconds moment, const std::stop_token& stop)>;

/// Gives every frame of a recording at its time: as long after the first as its time stamp says.
///
/// A frame whose time has passed is given at once: lost time is made up for. Frames before the selection are not waited
/// for.
/// @thread as Source
class PacedSource final : public devices::Source {
 public:
  PacedSource(std::unique_ptr<devices::Source> recording, const Clock& clock, WaitUntil wait,
              const FrameSelection& selection = {})
      : recording_(std::move(recording)), clock_(clock), wait_(std::move(wait)), selection_(selection) {}

  [[nodiscard]] const devices::SourceInfo& info() const override { return recording_->info(); }
  [[nodiscard]] devices::FramePtr read(std::stop_token stop) override;
  /// The recording's, and one more where its last frame came late.
  [[nodiscard]] std::vector<std::string> warnings() const override;

 private:
  std::unique_ptr<devices::Source> recording_;
  const Clock& clock_;
  WaitUntil wait_;
  FrameSelection selection_;
  std::optional<Nanoseconds> origin_;  // The recording's first time.
  std::optional<Nanoseconds> offset_;  // The clock minus the recording's time.
  Nanoseconds behind_{0};              // How late the last frame was read.
};

/// The frames of a source at a pace. What is no device has none of its own, whether or not it can be read again: it is
/// played as PacedSource does, unless the pace is kMax. A device is given back as it came.
[[nodiscard]] std::unique_ptr<devices::Source> at_pace(Pace pace, std::unique_ptr<devices::Source> source,
                                                       const Clock& clock, WaitUntil wait,
                                                       const FrameSelection& selection = {});

}  // namespace choreo::pipeline
