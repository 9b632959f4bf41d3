// SPDX-License-Identifier: Apache-2.0
// Drives the frames of a source through the stages.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "core/time.hpp"
#include "devices/source.hpp"
#include "pipeline/channel.hpp"
#include "pipeline/frame_selection.hpp"
#include "pipeline/latency.hpp"
#include "pipeline/stage.hpp"

namespace choreo::pipeline {

class RunMonitor;

struct RunnerOptions {
  int threads = 0;                 ///< 1: all stages in one thread; otherwise one thread a stage.
  std::size_t queue_capacity = 4;  ///< Observations that may wait before a stage.
  /// What the reader does where the first stage is behind. With kDropOldest, one observation waits there, the newest,
  /// and the reader never waits; it then has a thread of its own even with threads = 1.
  Overflow at_reader = Overflow::kBlock;
  RunMonitor* monitor = nullptr;  ///< Told of everything while the run goes on.
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
  Latency latency;  ///< From the stage before to the end of this one, waiting included. Empty for the reader.
};

struct RunReport {
  std::vector<StageStats> stages;  ///< The reader first.
  std::uint64_t frames = 0;        ///< That went the whole way.
  std::uint64_t frames_read = 0;   ///< Of the source, up to the last one needed; chosen or not.
  Latency latency;                 ///< From the source's giving a frame to the end of the last stage.
  Nanoseconds wall{0};
  bool interrupted = false;    ///< `stop` was requested.
  std::exception_ptr problem;  ///< What ended the run early; null if nothing did.
};

struct StageLatency {
  std::string name;
  Latency latency;  ///< As of StageStats.
};

/// Watches a run while it goes on.
/// @thread thread-safe
class RunMonitor {
 public:
  /// Before the first frame: the stages in order.
  void begin(const std::vector<std::unique_ptr<Stage>>& stages);
  void passed_stage(std::size_t stage, Nanoseconds latency) { (*stages_)[stage].histogram.add(latency); }
  void passed(Nanoseconds latency) { latency_.add(latency); }
  void dropped(std::uint64_t so_far) { dropped_.store(so_far, std::memory_order_relaxed); }

  [[nodiscard]] std::vector<StageLatency> stages() const;               ///< None before the run begins.
  [[nodiscard]] Latency latency() const { return latency_.summary(); }  ///< Its count is that of the frames.
  [[nodiscard]] std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

 private:
  struct Watched {
    explicit Watched(std::string n) : name(std::move(n)) {}
    std::string name;
    LatencyHistogram histogram;
  };
  mutable std::mutex mutex_;  // Of the pointer; what it points to stays.
  std::unique_ptr<std::deque<Watched>> stages_;
  LatencyHistogram latency_;
  std::atomic<std::uint64_t> dropped_{0};
};

/// Runs a source from its first frame to its last. Nothing is dropped but by `at_reader`.
///
/// The stages see the same observations in the same order, whatever the number of threads. No exception leaves a
/// thread: what ends the run is in the report, and what was finished before it went the whole way. A stage that fails
/// stops a `read` of the source that waits.
[[nodiscard]] RunReport run(devices::Source& source, const FrameSelection& selection,
                            const std::vector<std::unique_ptr<Stage>>& stages, const RunnerOptions& options,
                            const Clock& clock, const std::stop_token& stop);

}  // namespace choreo::pipeline
