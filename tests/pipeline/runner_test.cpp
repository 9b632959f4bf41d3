// SPDX-License-Identifier: Apache-2.0
// The way of the frames through the stages: order, selection, endings good and bad, with one thread and with many.
#include "pipeline/runner.hpp"

#include <atomic>
#include <condition_variable>
#include <latch>
#include <mutex>
#include <thread>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/fakes.hpp"
#include "support/frames.hpp"

namespace choreo::pipeline {
namespace {

using test::frames_every;
using test::FunctionStage;
using test::ListedSource;
using test::SimulatedClock;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using namespace std::chrono_literals;

using Seen = std::tuple<std::uint64_t, Nanoseconds, std::uint64_t>;  // Index, time, sequence.
using Stages = std::vector<std::unique_ptr<Stage>>;

std::string text_of(const std::exception_ptr& problem) {
  if (!problem) return {};
  try {
    std::rethrow_exception(problem);
  } catch (const std::exception& e) {
    return e.what();
  }
}

void add(Stages& stages, const std::string& name, std::function<void(Observation&)> work) {
  stages.push_back(std::make_unique<FunctionStage>(name, std::move(work)));
}

// Gives its frames, then waits as for a device that is lost: until it is stopped.
class LostSource final : public devices::Source {
 public:
  explicit LostSource(std::uint64_t frames, bool breaks = false)
      : frames_(frames_every(40ms, frames)), breaks_(breaks) {}

  [[nodiscard]] const devices::SourceInfo& info() const override { return frames_.info(); }
  devices::FramePtr read(std::stop_token stop) override {
    if (auto frame = frames_.read(stop)) return frame;
    waits_.count_down();
    std::mutex mutex;
    std::condition_variable_any never;
    std::unique_lock lock(mutex);
    // Longer than anything here takes, so that a test that fails ends.
    if (!stop.stop_requested()) never.wait_for(lock, stop, 10s, [] { return false; });
    was_stopped_ = stop.stop_requested();
    if (breaks_) throw failure("the source broke");
    return nullptr;
  }
  void wait_until_it_waits() const { waits_.wait(); }
  [[nodiscard]] bool was_stopped() const { return was_stopped_; }

 private:
  ListedSource frames_;
  bool breaks_;
  bool was_stopped_ = false;
  std::latch waits_{1};
};

// Everything holds with one thread and with one a stage.
class Runner : public ::testing::TestWithParam<int> {
 protected:
  Runner() {
    // Two stages that leave a trace in the observation, and one that keeps what arrives.
    add(stages_, "double", [](Observation& o) { o.quantity_of_motion = 2.0 * double(o.index); });
    add(stages_, "add", [this](Observation& o) {
      if (o.index == fail_at_) throw failure("the stage gave up");
      o.contraction = o.quantity_of_motion + 1;
    });
    add(stages_, "keep", [this](Observation& o) {
      if (on_keep_) on_keep_(o);
      EXPECT_EQ(o.contraction, 2.0 * double(o.index) + 1) << "every stage was there before";
      seen_.emplace_back(o.index, o.time, o.frame->sequence);
    });
  }

  RunReport run_all(devices::Source& source, const FrameSelection& selection = {}) {
    return run(source, selection, stages_, {GetParam(), capacity_}, clock_, stop_.get_token());
  }
  std::vector<Seen> seen_with(const std::string& span, std::uint64_t every, Nanoseconds begin = {}) {
    seen_.clear();
    ListedSource source(frames_every(100ms, 40, begin));
    auto selection = span.empty() ? FrameSelection{} : parse_span(span);
    selection.every = every;
    const auto report = run_all(source, selection);
    EXPECT_FALSE(report.problem);
    EXPECT_EQ(report.frames, seen_.size());
    return seen_;
  }
  std::vector<std::uint64_t> sequences_with(const std::string& span, std::uint64_t every = 1, Nanoseconds begin = {}) {
    std::vector<std::uint64_t> all;
    for (const auto& [index, time, sequence] : seen_with(span, every, begin)) {
      EXPECT_EQ(index, all.size()) << "counts the frames taken";
      EXPECT_EQ(time, 100ms * static_cast<long>(sequence)) << "since the source's first frame";
      all.push_back(sequence);
    }
    return all;
  }

  SimulatedClock clock_;
  std::stop_source stop_;
  std::size_t capacity_ = 2;
  std::uint64_t fail_at_ = 1'000'000;
  std::function<void(Observation&)> on_keep_;
  Stages stages_;
  std::vector<Seen> seen_;
};

INSTANTIATE_TEST_SUITE_P(Threads, Runner, ::testing::Values(1, 0, 4));

TEST_P(Runner, EveryFrameGoesTheWholeWayInOrder) {
  for (const std::size_t capacity : {1u, 4u}) {
    capacity_ = capacity;
    seen_.clear();
    ListedSource source(frames_every(40ms, 300, 5s));
    const auto report = run_all(source);
    ASSERT_THAT(seen_, SizeIs(300));
    for (std::uint64_t i = 0; i < 300; ++i) EXPECT_EQ(seen_[i], Seen(i, 40ms * static_cast<long>(i), i));
    EXPECT_EQ(report.frames, 300u);
    EXPECT_EQ(report.frames_read, 300u);
    EXPECT_FALSE(report.interrupted);
    EXPECT_FALSE(report.problem);
    ASSERT_THAT(report.stages, SizeIs(4));
    EXPECT_THAT(report.stages, ElementsAre(Field(&StageStats::name, "read"), Field(&StageStats::name, "double"),
                                           Field(&StageStats::name, "add"), Field(&StageStats::name, "keep")));
    EXPECT_THAT(report.stages, Each(Field(&StageStats::frames, 300u)));
    EXPECT_THAT(report.stages, Each(Field(&StageStats::dropped, 0u)));
    for (const auto& stage : report.stages) EXPECT_LE(stage.longest_queue, capacity) << stage.name;
  }
}

TEST_P(Runner, UnevenTimesAndGapsInTheSequenceAreKept) {
  ListedSource source({test::frame_at(0, 7s), test::frame_at(1, 7s + 33ms), test::frame_at(5, 8s)});
  (void)run_all(source);
  EXPECT_THAT(seen_, ElementsAre(Seen(0, 0ns, 0), Seen(1, 33ms, 1), Seen(2, 1s, 5)));
}

TEST_P(Runner, ASpanInSecondsIsHalfOpen) {
  EXPECT_THAT(sequences_with("0.3:0.6"), ElementsAre(3, 4, 5));
  EXPECT_THAT(sequences_with("3.7:"), ElementsAre(37, 38, 39));
  EXPECT_THAT(sequences_with(":0.25"), ElementsAre(0, 1, 2));
  EXPECT_THAT(sequences_with("100:200"), IsEmpty());
}

TEST_P(Runner, ASpanInFramesHasBothEndsIn) {
  EXPECT_THAT(sequences_with("4f:6f"), ElementsAre(3, 4, 5));
  EXPECT_THAT(sequences_with("39f:"), ElementsAre(38, 39));
  EXPECT_THAT(sequences_with("1f:1f"), ElementsAre(0));
}

TEST_P(Runner, EveryTakesTheFirstOfEachNWithinTheSpan) {
  EXPECT_THAT(sequences_with("", 15), ElementsAre(0, 15, 30));
  EXPECT_THAT(sequences_with("0.5:1.3", 3), ElementsAre(5, 8, 11));
  EXPECT_THAT(sequences_with("2f:9f", 4), ElementsAre(1, 5));
  EXPECT_THAT(sequences_with("", 1000), ElementsAre(0));
}

TEST_P(Runner, TimesCountFromTheSourcesFirstFrameEvenIfTheSpanBeginsLater) {
  for (const auto begin : {Nanoseconds(1h), Nanoseconds(-1h)}) {
    EXPECT_THAT(seen_with("3.7:3.9", 1, begin), ElementsAre(Seen(0, 3700ms, 37), Seen(1, 3800ms, 38)));
  }
}

TEST_P(Runner, ReadsNoFurtherThanTheSpan) {
  ListedSource in_frames(frames_every(100ms, 40));
  in_frames.before_read = [](std::size_t next) {
    if (next >= 6) throw failure("the recording is broken behind the span");
  };
  const auto report = run_all(in_frames, parse_span("4f:6f"));
  EXPECT_EQ(text_of(report.problem), "");
  EXPECT_EQ(report.frames, 3u);
  EXPECT_EQ(report.frames_read, 6u);

  ListedSource in_seconds(frames_every(100ms, 40));
  EXPECT_EQ(run_all(in_seconds, parse_span("0:1")).frames_read, 10u);
  EXPECT_EQ(in_seconds.frames_given(), 11u) << "one more, to know that it is past";
}

TEST_P(Runner, FramesThatWereOvertakenAreCountedAndGoNoFurther) {
  auto frames = frames_every(100ms, 8, 3s);
  for (const std::size_t i : {0, 3, 4}) {
    auto overtaken = std::make_shared<devices::Frame>(*frames[i]);
    overtaken->overtaken = true;
    frames[i] = overtaken;
  }
  ListedSource source(frames);
  FrameSelection selection;
  selection.every = 2;  // Of 0, 2, 4 and 6 those that were not overtaken.
  const auto report = run_all(source, selection);
  EXPECT_THAT(seen_, ElementsAre(Seen(1, 200ms, 2), Seen(3, 600ms, 6))) << "numbers and times as in the run before";
  EXPECT_EQ(report.frames_read, 8u);
}

TEST_P(Runner, ASourceWithoutFramesEndsAtOnce) {
  ListedSource source({});
  const auto report = run_all(source);
  EXPECT_EQ(report.frames, 0u);
  EXPECT_EQ(report.frames_read, 0u);
  EXPECT_FALSE(report.problem);
}

TEST_P(Runner, WithoutStagesTheFramesAreJustRead) {
  ListedSource source(frames_every(100ms, 3));
  const auto report = run(source, {}, {}, {GetParam(), 1}, clock_, {});
  EXPECT_EQ(report.frames, 3u);
  EXPECT_THAT(report.stages, SizeIs(1));
}

TEST_P(Runner, AStageThatFailsEndsTheRunAndWhatWasBeforeIsFinished) {
  for (const std::size_t capacity : {1u, 8u}) {
    capacity_ = capacity;
    for (const std::uint64_t at : {0u, 1u, 17u, 299u}) {
      seen_.clear();
      fail_at_ = at;
      ListedSource source(frames_every(40ms, 300));
      const auto report = run_all(source);
      EXPECT_EQ(text_of(report.problem), "the stage gave up");
      EXPECT_EQ(report.frames, at);
      EXPECT_THAT(seen_, SizeIs(at));
      EXPECT_EQ(report.stages[2].frames, at) << "the frame it failed at does not count";
      EXPECT_FALSE(report.interrupted);
    }
  }
}

TEST_P(Runner, WhateverAStageThrowsIsInTheReport) {
  Stages stages;
  add(stages, "odd", [](Observation&) { throw 5; });  // NOLINT: not an exception class on purpose.
  ListedSource source(frames_every(40ms, 20));
  const auto report = run(source, {}, stages, {GetParam(), 2}, clock_, {});
  ASSERT_TRUE(report.problem);
  EXPECT_THROW(std::rethrow_exception(report.problem), int);
}

TEST_P(Runner, ASourceThatFailsEndsTheRunAndWhatWasReadIsFinished) {
  ListedSource source(frames_every(40ms, 300));
  source.before_read = [](std::size_t next) {
    if (next == 123) throw failure("the frame size changes");
  };
  const auto report = run_all(source);
  EXPECT_EQ(text_of(report.problem), "the frame size changes");
  EXPECT_EQ(report.frames, 123u);
  EXPECT_THAT(seen_, SizeIs(123));
}

TEST_P(Runner, OfSeveralProblemsTheReportHasTheOneOfTheEarliestFrame) {
  // With many threads the reader may be ahead of the stage that fails: the answer is the same as with one.
  for (int round = 0; round < 50; ++round) {
    seen_.clear();
    capacity_ = 8;
    fail_at_ = 10;
    ListedSource source(frames_every(40ms, 300));
    source.before_read = [](std::size_t next) {
      if (next == 12) throw failure("the source broke");
    };
    const auto report = run_all(source);
    EXPECT_EQ(text_of(report.problem), "the stage gave up");
    EXPECT_EQ(report.frames, 10u);
  }
}

TEST_P(Runner, AStageThatFailsEndsTheWaitForALostDevice) {
  for (const auto at_reader : {Overflow::kBlock, Overflow::kDropOldest}) {
    if (GetParam() == 1 && at_reader == Overflow::kBlock) continue;  // Nothing is read beside the stages.
    for (const bool source_breaks : {false, true}) {
      for (std::size_t failing = 0; failing < 3; ++failing) {
        LostSource source(3, source_breaks);
        Stages stages;
        for (std::size_t s = 0; s < 3; ++s) {
          add(stages, "some", [&source, fails = s == failing](Observation& o) {
            if (!fails || o.frame->sequence != 2) return;
            source.wait_until_it_waits();
            throw failure("the stage gave up");
          });
        }
        const auto report = run(source, {}, stages, {GetParam(), 2, at_reader}, clock_, stop_.get_token());
        EXPECT_EQ(text_of(report.problem), "the stage gave up") << "whatever the reader met because it was stopped";
        EXPECT_TRUE(source.was_stopped());
        EXPECT_FALSE(report.interrupted) << "nobody asked for that";
        EXPECT_EQ(report.frames_read, 3u);
        EXPECT_EQ(report.stages[failing + 1].frames, 2u - report.stages[1].dropped);
        if (HasFailure()) return;  // Each of the others would wait as long.
      }
    }
  }
}

TEST_P(Runner, StoppedWhileTheSourceWaitsItIsInterrupted) {
  on_keep_ = [&](const Observation& o) {
    if (o.index == 2) stop_.request_stop();
  };
  LostSource source(3);
  const auto report = run_all(source);
  EXPECT_TRUE(report.interrupted);
  EXPECT_FALSE(report.problem);
  EXPECT_EQ(report.frames, 3u);
}

TEST_P(Runner, WhenStoppedMidwayWhatWasReadGoesTheWholeWay) {
  on_keep_ = [&](const Observation& o) {
    if (o.index == 20) stop_.request_stop();
  };
  ListedSource source(frames_every(40ms, 3000));
  const auto report = run_all(source);
  EXPECT_TRUE(report.interrupted);
  EXPECT_FALSE(report.problem);
  EXPECT_GE(report.frames, 21u);
  EXPECT_LT(report.frames, 60u) << "no more than the queues hold";
  EXPECT_EQ(report.frames, source.frames_given());
  EXPECT_THAT(report.stages, Each(Field(&StageStats::frames, report.frames)));
  for (std::uint64_t i = 0; i < seen_.size(); ++i) EXPECT_EQ(std::get<0>(seen_[i]), i);
}

TEST_P(Runner, StoppedBeforeItBeginsItReadsNothing) {
  stop_.request_stop();
  ListedSource source(frames_every(40ms, 30));
  const auto report = run_all(source);
  EXPECT_TRUE(report.interrupted);
  EXPECT_EQ(report.frames, 0u);
  EXPECT_EQ(source.frames_given(), 0u);
}

TEST_P(Runner, BusyTimeIsTheWorkAlone) {
  Stages stages;
  add(stages, "picture", [](Observation&) { test::OwnTimeClock::advance(3ms); });
  add(stages, "a-name-longer-than-a-thread-may-have", [](Observation&) { test::OwnTimeClock::advance(5ms); });
  ListedSource source(frames_every(40ms, 10));
  source.before_read = [](std::size_t) { test::OwnTimeClock::advance(2ms); };
  const auto report = run(source, {}, stages, {GetParam(), 2}, test::OwnTimeClock(), {});
  EXPECT_EQ(report.stages[0].busy, 11 * 2ms) << "the end is read too";
  EXPECT_EQ(report.stages[1].busy, 10 * 3ms);
  EXPECT_EQ(report.stages[2].busy, 10 * 5ms);
  EXPECT_THAT(report.stages, Each(Field(&StageStats::waiting, 0ns)));
  EXPECT_EQ(report.wall, GetParam() == 1 ? 22ms + 30ms + 50ms : 22ms) << "as the calling thread has it";
}

TEST(RunnerTimes, WaitingIsCountedApartFromWork) {
  // The first frame is read only once the stage waits for it, and that takes 7 ms; then the stage works for 5 ms.
  SimulatedClock clock;
  std::latch waits(1);
  const auto caller = std::this_thread::get_id();
  std::atomic<bool> first = true;
  clock.on_now = [&] {
    if (std::this_thread::get_id() != caller && first.exchange(false)) waits.count_down();
  };
  ListedSource source(frames_every(40ms, 1));
  source.before_read = [&](std::size_t next) {
    if (next == 0) {
      waits.wait();
      clock.advance(7ms);
    }
  };
  Stages stages;
  add(stages, "work", [&](Observation&) { clock.advance(5ms); });
  const auto report = run(source, {}, stages, {0, 1}, clock, {});
  EXPECT_EQ(report.stages[1].busy, 5ms);
  EXPECT_EQ(report.stages[1].waiting, 7ms);
  EXPECT_GE(report.stages[0].busy, 7ms);
  EXPECT_EQ(report.wall, 12ms);
}

}  // namespace
}  // namespace choreo::pipeline
