// SPDX-License-Identifier: Apache-2.0
#include "pipeline/runner.hpp"

#include <pthread.h>

#include <optional>
#include <thread>
#include <utility>

#include "pipeline/channel.hpp"

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

void run_inline(Reader& reader, const std::vector<std::unique_ptr<Stage>>& stages, const Clock& clock,
                const std::stop_token& stop, RunReport& report) {
  try {
    while (true) {
      ObservationPtr observation;
      {
        const Lap lap(clock, report.stages[0].busy);
        observation = reader.next(stop);
      }
      if (!observation) return;
      ++report.stages[0].frames;
      for (std::size_t s = 0; s < stages.size(); ++s) {
        const Lap lap(clock, report.stages[s + 1].busy);
        stages[s]->process(*observation);
        ++report.stages[s + 1].frames;
      }
      ++report.frames;
    }
  } catch (...) {
    report.problem = std::current_exception();
  }
}

void run_threaded(Reader& reader, const std::vector<std::unique_ptr<Stage>>& stages, std::size_t capacity,
                  const Clock& clock, const std::stop_token& stop, RunReport& report) {
  // channels[s] leads to stages[s]. Closing one lets what waits in it through: what was read goes the whole way, also
  // after Ctrl-C. Only a stage that fails breaks the chain, by closing the channel before it as well.
  std::vector<std::unique_ptr<Channel<ObservationPtr>>> channels;
  for (std::size_t s = 0; s < stages.size(); ++s) {
    channels.push_back(std::make_unique<Channel<ObservationPtr>>(capacity));
  }
  std::vector<std::exception_ptr> problems(stages.size() + 1);

  {
    std::vector<std::jthread> threads;
    const auto work = [&](std::size_t s) {
      auto& stats = report.stages[s + 1];
      auto* next = s + 1 < stages.size() ? channels[s + 1].get() : nullptr;
      try {
        pthread_setname_np(pthread_self(), stages[s]->name().substr(0, 15).c_str());
        while (true) {
          std::optional<ObservationPtr> observation;
          {
            const Lap lap(clock, stats.waiting);
            observation = channels[s]->pop();
          }
          if (!observation) break;
          {
            const Lap lap(clock, stats.busy);
            stages[s]->process(**observation);
          }
          ++stats.frames;
          if (next == nullptr) continue;
          const Lap lap(clock, stats.waiting);
          if (!next->push(std::move(*observation))) break;
        }
      } catch (...) {
        problems[s + 1] = std::current_exception();
      }
      channels[s]->close();
      if (next != nullptr) next->close();
    };
    auto& stats = report.stages[0];
    try {
      for (std::size_t s = 0; s < stages.size(); ++s) threads.emplace_back(work, s);
      // The calling thread reads.
      while (true) {
        ObservationPtr observation;
        {
          const Lap lap(clock, stats.busy);
          observation = reader.next(stop);
        }
        if (!observation) break;
        ++stats.frames;
        const Lap lap(clock, stats.waiting);
        if (!channels[0]->push(std::move(observation))) break;
      }
    } catch (...) {
      problems[0] = std::current_exception();
    }
    // The channel of a stage without a thread, where the system had no more, is closed by the stage before it.
    channels[0]->close();
  }

  for (std::size_t s = 0; s < stages.size(); ++s) {
    const auto stats = channels[s]->stats();
    report.stages[s + 1].dropped = stats.dropped;
    report.stages[s + 1].mean_queue = stats.mean_length;
    report.stages[s + 1].longest_queue = stats.longest;
  }
  report.frames = report.stages.back().frames;
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

RunReport run(devices::Source& source, const FrameSelection& selection,
              const std::vector<std::unique_ptr<Stage>>& stages, const RunnerOptions& options, const Clock& clock,
              const std::stop_token& stop) {
  RunReport report;
  report.stages.resize(stages.size() + 1);
  report.stages[0].name = "read";
  for (std::size_t s = 0; s < stages.size(); ++s) report.stages[s + 1].name = stages[s]->name();

  Reader reader(source, selection);
  const auto start = clock.now();
  if (options.threads == 1 || stages.empty()) {
    run_inline(reader, stages, clock, stop, report);
  } else {
    run_threaded(reader, stages, options.queue_capacity, clock, stop, report);
  }
  report.wall = clock.now() - start;
  report.frames_read = reader.frames_read();
  report.interrupted = stop.stop_requested();
  return report;
}

}  // namespace choreo::pipeline
