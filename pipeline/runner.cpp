// SPDX-License-Identifier: Apache-2.0
#include "pipeline/runner.hpp"

#include <pthread.h>

#include <optional>
#include <thread>
#include <utility>

namespace choreo::pipeline {
namespace {

// Chooses the frames, numbers them, and gives them the time since the source's first frame.
class Reader {
 public:
  Reader(devices::Source& source, const FrameSelection& selection) : source_(source), selection_(selection) {}

  ObservationPtr next(const std::stop_token& stop) {
    while (!stop.stop_requested() && !done_) {
      auto frame = source_.read(stop);
      if (!frame) return nullptr;
      if (!origin_) origin_ = frame->device_time;
      const auto time = frame->device_time - *origin_;
      const auto number = frame->sequence + 1;
      if (selection_.past(number, time)) return nullptr;
      ++frames_read_;
      // What lies behind the span is not looked at: it may be broken.
      done_ = number >= selection_.last_frame;
      if (selection_.before(number, time)) continue;
      if (in_span_++ % selection_.every != 0) continue;
      if (frame->overtaken) {
        ++taken_;  // As it was where it was overtaken.
        continue;
      }
      auto observation = std::make_unique<Observation>();
      observation->index = taken_++;
      observation->time = time;
      observation->frame = std::move(frame);
      return observation;
    }
    return nullptr;
  }

  [[nodiscard]] std::uint64_t frames_read() const { return frames_read_; }
  [[nodiscard]] std::uint64_t frames_taken() const { return taken_; }

 private:
  devices::Source& source_;
  const FrameSelection& selection_;
  std::optional<Nanoseconds> origin_;
  std::uint64_t frames_read_ = 0;
  std::uint64_t in_span_ = 0;
  std::uint64_t taken_ = 0;
  bool done_ = false;
};

// Adds the time from its making to its end to a sum.
class Lap {
 public:
  Lap(const Clock& clock, Nanoseconds& sum) : clock_(clock), sum_(sum), start_(clock.now()) {}
  ~Lap() { sum_ += clock_.now() - start_; }
  Lap(const Lap&) = delete;
  Lap& operator=(const Lap&) = delete;

 private:
  const Clock& clock_;
  Nanoseconds& sum_;
  Nanoseconds start_;
};

using Stages = std::vector<std::unique_ptr<Stage>>;

// Takes observations through stages and keeps what that took.
class Conductor {
 public:
  Conductor(const Stages& stages, const Clock& clock, RunMonitor* monitor, RunReport& report)
      : stages_(stages), clock_(clock), monitor_(monitor != nullptr ? *monitor : own_monitor_), report_(report) {
    monitor_.begin(stages);
  }

  /// @thread one a stage; each only touches what belongs to its stages.
  void process(std::size_t s, Observation& observation) {
    auto& stats = report_.stages[s + 1];
    {
      const Lap lap(clock_, stats.busy);
      stages_[s]->process(observation);
    }
    ++stats.frames;
    const auto now = clock_.now();
    monitor_.passed_stage(s, now - observation.passed);
    observation.passed = now;
    if (s + 1 == stages_.size()) monitor_.passed(now - observation.arrived);
  }

  void finish() {
    const auto latencies = monitor_.stages();
    for (std::size_t s = 0; s < stages_.size(); ++s) report_.stages[s + 1].latency = latencies[s].latency;
    report_.latency = monitor_.latency();
    report_.frames = report_.stages.back().frames;
  }

 private:
  const Stages& stages_;
  const Clock& clock_;
  RunMonitor own_monitor_;  // Where nobody else watches.
  RunMonitor& monitor_;
  RunReport& report_;
};

ObservationPtr read_next(Reader& reader, const Clock& clock, const std::stop_token& stop, StageStats& stats) {
  ObservationPtr observation;
  {
    const Lap lap(clock, stats.busy);
    observation = reader.next(stop);
  }
  if (observation) {
    observation->arrived = observation->passed = clock.now();
    ++stats.frames;
  }
  return observation;
}

void run_inline(Reader& reader, const Stages& stages, Conductor& conductor, const Clock& clock,
                const std::stop_token& stop, RunReport& report) {
  try {
    while (const auto observation = read_next(reader, clock, stop, report.stages[0])) {
      for (std::size_t s = 0; s < stages.size(); ++s) conductor.process(s, *observation);
    }
  } catch (...) {
    report.problem = std::current_exception();
  }
}

// The stages from `begin` to `end` share a thread.
struct Group {
  std::size_t begin;
  std::size_t end;
};

void run_threaded(Reader& reader, const Stages& stages, const std::vector<Group>& groups, const RunnerOptions& options,
                  Conductor& conductor, const Clock& clock, const std::stop_token& stop, RunReport& report) {
  // channels[g] leads to groups[g]. Closing one lets what waits in it through: what was read goes the whole way, also
  // after Ctrl-C. Only a stage that fails breaks the chain, by closing the channel before it as well.
  std::vector<std::unique_ptr<Channel<ObservationPtr>>> channels;
  const bool newest_wins = options.at_reader == Overflow::kDropOldest;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    channels.push_back(g == 0 && newest_wins ? std::make_unique<Channel<ObservationPtr>>(1, Overflow::kDropOldest)
                                             : std::make_unique<Channel<ObservationPtr>>(options.queue_capacity));
  }
  // Where the reader's is first, then each stage's.
  std::vector<std::exception_ptr> problems(stages.size() + 1);
  // The reader may wait for a device that is lost, for ever: a stage that fails ends that, too. Whatever the reader
  // would have met afterwards is of a later frame than the one that failed, and no problem to report.
  std::stop_source reading;
  const std::stop_callback asked(stop, [&] { reading.request_stop(); });

  {
    std::vector<std::jthread> threads;
    const auto work = [&](std::size_t g) {
      auto& stats = report.stages[groups[g].begin + 1];
      auto* next = g + 1 < groups.size() ? channels[g + 1].get() : nullptr;
      auto at = groups[g].begin;
      try {
        pthread_setname_np(pthread_self(), stages[at]->name().substr(0, 15).c_str());
        while (true) {
          std::optional<ObservationPtr> observation;
          {
            const Lap lap(clock, stats.waiting);
            observation = channels[g]->pop();
          }
          if (!observation) break;
          for (at = groups[g].begin; at < groups[g].end; ++at) conductor.process(at, **observation);
          at = groups[g].begin;
          if (next == nullptr) continue;
          const Lap lap(clock, stats.waiting);
          if (!next->push(std::move(*observation))) break;
        }
      } catch (...) {
        problems[at + 1] = std::current_exception();
      }
      channels[g]->close();
      if (next != nullptr) next->close();
      if (problems[at + 1]) reading.request_stop();
    };
    auto& stats = report.stages[0];
    try {
      for (std::size_t g = 0; g < groups.size(); ++g) threads.emplace_back(work, g);
      // The calling thread reads.
      while (auto observation = read_next(reader, clock, reading.get_token(), stats)) {
        const Lap lap(clock, stats.waiting);
        if (!channels[0]->push(std::move(observation))) break;
        if (newest_wins && options.monitor != nullptr) options.monitor->dropped(channels[0]->stats().dropped);
      }
    } catch (...) {
      problems[0] = std::current_exception();
    }
    // The channel of a stage without a thread, where the system had no more, is closed by the stage before it.
    channels[0]->close();
  }

  for (std::size_t g = 0; g < groups.size(); ++g) {
    auto& stats = report.stages[groups[g].begin + 1];
    const auto of_channel = channels[g]->stats();
    stats.dropped = of_channel.dropped;
    stats.mean_queue = of_channel.mean_length;
    stats.longest_queue = of_channel.longest;
  }
  // The problem of the earliest frame, as with one thread: a reader that is ahead may have met a later one before. What
  // failed had finished as many frames as its count says, and no two fail at the same frame.
  std::optional<std::uint64_t> earliest;
  for (std::size_t i = 0; i < problems.size(); ++i) {
    if (!problems[i] || (earliest && *earliest <= report.stages[i].frames)) continue;
    earliest = report.stages[i].frames;
    report.problem = problems[i];
  }
}

}  // namespace

void RunMonitor::begin(const std::vector<std::unique_ptr<Stage>>& stages) {
  auto watched = std::make_unique<std::deque<Watched>>();
  for (const auto& stage : stages) watched->emplace_back(stage->name());
  const std::scoped_lock lock(mutex_);
  stages_ = std::move(watched);
}

std::vector<StageLatency> RunMonitor::stages() const {
  const std::scoped_lock lock(mutex_);
  std::vector<StageLatency> all;
  if (!stages_) return all;
  for (const auto& stage : *stages_) all.push_back({stage.name, stage.histogram.summary()});
  return all;
}

RunReport run(devices::Source& source, const FrameSelection& selection,
              const std::vector<std::unique_ptr<Stage>>& stages, const RunnerOptions& options, const Clock& clock,
              const std::stop_token& stop) {
  RunReport report;
  report.stages.resize(stages.size() + 1);
  report.stages[0].name = "read";
  for (std::size_t s = 0; s < stages.size(); ++s) report.stages[s + 1].name = stages[s]->name();

  Reader reader(source, selection);
  const auto start = clock.now();
  Conductor conductor(stages, clock, options.monitor, report);
  const bool one_thread = options.threads == 1 || stages.empty();
  if (one_thread && (options.at_reader == Overflow::kBlock || stages.empty())) {
    run_inline(reader, stages, conductor, clock, stop, report);
  } else {
    std::vector<Group> groups;
    for (std::size_t s = 0; s < stages.size(); ++s) groups.push_back({s, s + 1});
    if (one_thread) groups = {{0, stages.size()}};
    run_threaded(reader, stages, groups, options, conductor, clock, stop, report);
  }
  conductor.finish();
  report.wall = clock.now() - start;
  report.frames_read = reader.frames_read();
  report.interrupted = stop.stop_requested();
  return report;
}

}  // namespace choreo::pipeline
