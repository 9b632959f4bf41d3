// SPDX-License-Identifier: Apache-2.0
// Drives the frames of a source through the stages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "core/time.hpp"
#include "devices/source.hpp"
#include "pipeline/frame_selection.hpp"
#include "pipeline/stage.hpp"

namespace choreo::pipeline {

struct RunnerOptions {
  int threads = 0;                 ///< 1: everything in the calling thread; otherwise one thread a stage.
  std::size_t queue_capacity = 4;  ///< Observations that may wait before a stage.
};

/// Where a stage's time went.
struct StageStats {
  std::string name;
  std::uint64_t frames = 0;
  std::uint64_t dropped = 0;  ///< Lost on the way to this stage.
  Nanoseconds busy{0};        ///< Working.
  Nanoseconds waiting{0};     ///< Waiting for the stage before or the one behind.
  double mean_queue = 0;      ///< Observations waiting before it, on average as one arrives.
  std::size_t longest_queue = 0;
};

struct RunReport {
  std::vector<StageStats> stages;  ///< The reader first.
  std::uint64_t frames = 0;        ///< That went the whole way.
  std::uint64_t frames_read = 0;   ///< Of the source, up to the last one needed; chosen or not.
  Nanoseconds wall{0};
  bool interrupted = false;     ///< `stop` was requested.
  std::exception_ptr problem;   ///< What ended the run early; null if nothing did.
};

/// Runs a recording from its first frame to its last: nothing is dropped, the reader waits for the stages.
///
/// The stages see the same observations in the same order, whatever the number of threads. No exception leaves a
/// thread: what ends the run is in the report, and what was finished before it went the whole way.
[[nodiscard]] RunReport run(devices::Source& source, const FrameSelection& selection,
                            const std::vector<std::unique_ptr<Stage>>& stages, const RunnerOptions& options,
                            const Clock& clock, const std::stop_token& stop);

}  // namespace choreo::pipeline
