// SPDX-License-Identifier: Apache-2.0
// A recording at its own time, and the newest frame that wins.
#include "pipeline/pacing.hpp"

#include <latch>
#include <thread>

#include <gmock/gmock.h>

#include "pipeline/fakes.hpp"
#include "pipeline/runner.hpp"
#include "pipeline/steady_clock.hpp"
#include "support/frames.hpp"

namespace choreo::pipeline {
namespace {

using test::frame_at;
using test::frames_every;
using test::FunctionStage;
using test::ListedSource;
using test::SimulatedClock;
using ::testing::ElementsAre;
using namespace std::chrono_literals;

TEST(ParsePace, KnowsThreeAndListsThem) {
  EXPECT_EQ(parse_pace("live"), Pace::kLive);
  EXPECT_EQ(parse_pace("replay"), Pace::kReplay);
  EXPECT_EQ(parse_pace("max"), Pace::kMax);
  const auto error = test::error_of([] { (void)parse_pace("slow"); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->hint(), "known: live, replay, max");
}

class Paced : public ::testing::Test {
 protected:
  std::vector<Nanoseconds> given_at(std::vector<devices::FramePtr> frames) {
    PacedSource source(std::make_unique<ListedSource>(std::move(frames)), clock_, wait());
    std::vector<Nanoseconds> moments;
    while (source.read({})) {
      moments.push_back(clock_.now());
      clock_.advance(work_);
    }
    return moments;
  }
  // Time passes only while somebody waits for it.
  WaitUntil wait() {
    return [this](Nanoseconds moment, const std::stop_token& stop) {
      if (moment > clock_.now()) clock_.advance(moment - clock_.now());
      return !stop.stop_requested();
    };
  }

  SimulatedClock clock_;
  Nanoseconds work_{0};
};

TEST_F(Paced, ARecordingThatFallsBehindSaysSoAndOneThatCatchesUpDoesNot) {
  const auto warnings_after = [&](Nanoseconds last) {
    PacedSource source(std::make_unique<ListedSource>(std::vector{frame_at(0, 0s), frame_at(1, last)}), clock_, wait());
    (void)source.read({});
    clock_.advance(1s);  // Somebody is busy.
    (void)source.read({});
    return source.warnings();
  };
  EXPECT_THAT(warnings_after(100ms), ElementsAre(testing::_, testing::HasSubstr("came 0.9 s late")));
  EXPECT_THAT(warnings_after(2s), ElementsAre(testing::_)) << "the recording's own alone";
}

TEST_F(Paced, FramesComeAsFarApartAsTheirTimeStamps) {
  clock_.advance(1000s);
  EXPECT_THAT(given_at({frame_at(0, 7s), frame_at(1, 7s + 33ms), frame_at(2, 8s)}),
              ElementsAre(1000s, 1000s + 33ms, 1001s));
}

TEST_F(Paced, LostTimeIsMadeUpForAndNoFrameIsLost) {
  work_ = 250ms;
  EXPECT_THAT(given_at(frames_every(100ms, 4)), ElementsAre(0ms, 250ms, 500ms, 750ms));
  work_ = 10ms;
  clock_.advance(-clock_.now());
  EXPECT_THAT(given_at(frames_every(100ms, 3)), ElementsAre(0ms, 100ms, 200ms));
}

TEST_F(Paced, FramesBeforeTheSpanAreNotWaitedFor) {
  PacedSource source(std::make_unique<ListedSource>(frames_every(100ms, 8)), clock_, wait(), parse_span("0.5:"));
  std::vector<Nanoseconds> moments;
  while (source.read({})) moments.push_back(clock_.now());
  EXPECT_THAT(moments, ElementsAre(0ms, 0ms, 0ms, 0ms, 0ms, 0ms, 100ms, 200ms));
}

TEST_F(Paced, AStopEndsTheWait) {
  std::stop_source stop;
  const SteadyClock clock;
  PacedSource source(std::make_unique<ListedSource>(frames_every(1h, 2)), clock, sleep_until);
  EXPECT_NE(source.read(stop.get_token()), nullptr);
  std::jthread later([&] { stop.request_stop(); });
  EXPECT_EQ(source.read(stop.get_token()), nullptr) << "long before the hour is over";
}

// A pipe and a recording behind an address give their frames once, as a device does, and as fast as they are read.
TEST_F(Paced, OnlyADeviceHasAPaceOfItsOwn) {
  const auto last_given_at = [&](Pace pace, bool live, bool repeatable) {
    clock_.advance(-clock_.now());
    devices::SourceInfo info;
    info.live = live;
    info.repeatable = repeatable;
    const auto source = at_pace(pace, std::make_unique<ListedSource>(frames_every(100ms, 3), info), clock_, wait());
    while (source->read({})) continue;
    return clock_.now();
  };
  for (const auto pace : {Pace::kLive, Pace::kReplay}) {
    EXPECT_EQ(last_given_at(pace, false, true), 200ms) << "a file";
    EXPECT_EQ(last_given_at(pace, false, false), 200ms) << "a pipe";
    EXPECT_EQ(last_given_at(pace, true, false), 0ms) << "a camera";
  }
  EXPECT_EQ(last_given_at(Pace::kMax, false, true), 0ms);
  EXPECT_EQ(last_given_at(Pace::kMax, false, false), 0ms);
}

TEST(SleepUntil, AMomentThatHasPassedIsNotWaitedFor) {
  const SteadyClock clock;
  EXPECT_TRUE(sleep_until(clock.now() - 1h, {}));
  const auto soon = clock.now() + 5ms;
  EXPECT_TRUE(sleep_until(soon, {}));
  EXPECT_GE(clock.now(), soon);
}

// The first frame is held in the first stage until the reader has read all the others.
class NewestWins : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Threads, NewestWins, ::testing::Values(1, 0));

TEST_P(NewestWins, WhatIsOvertakenIsCountedAndTheRestGoesTheWholeWay) {
  std::latch all_read(1);
  std::latch begun(1);
  ListedSource source(frames_every(40ms, 30));
  source.before_read = [&](std::size_t next) {
    if (next == 1) begun.wait();
    if (next == 30) all_read.count_down();
  };
  std::vector<std::uint64_t> seen;
  std::vector<std::unique_ptr<Stage>> stages;
  stages.push_back(std::make_unique<FunctionStage>("slow", [&](Observation& o) {
    if (o.index > 0) return;
    begun.count_down();
    all_read.wait();
  }));
  stages.push_back(std::make_unique<FunctionStage>("keep", [&](Observation& o) { seen.push_back(o.index); }));
  RunMonitor monitor;
  RunnerOptions options;
  options.threads = GetParam();
  options.at_reader = Overflow::kDropOldest;
  options.monitor = &monitor;
  const auto report = run(source, {}, stages, options, SimulatedClock(), {});
  EXPECT_THAT(seen, ElementsAre(0, 29)) << "the newest of those that came meanwhile";
  EXPECT_EQ(report.stages[1].dropped, 28u);
  EXPECT_EQ(report.stages[0].frames, report.frames + 28) << "no frame is lost uncounted";
  EXPECT_EQ(monitor.dropped(), 28u);
  EXPECT_EQ(monitor.latency().count, 2u);
  ASSERT_THAT(monitor.stages(), testing::SizeIs(2));
  EXPECT_EQ(monitor.stages()[0].name, "slow");
  EXPECT_EQ(monitor.stages()[1].latency.count, 2u);
}

TEST(RunLatency, IsKeptFromStageToStageAndFromEndToEnd) {
  SimulatedClock clock;
  ListedSource source(frames_every(40ms, 10));
  source.before_read = [&](std::size_t) { clock.advance(100ms); };
  std::vector<std::unique_ptr<Stage>> stages;
  stages.push_back(std::make_unique<FunctionStage>("mask", [&](Observation&) { clock.advance(3ms); }));
  stages.push_back(
      std::make_unique<FunctionStage>("compare", [&](Observation& o) { clock.advance(o.index == 7 ? 50ms : 2ms); }));
  const auto report = run(source, {}, stages, {1}, clock, {});
  EXPECT_EQ(report.stages[0].latency.count, 0u) << "the reader waits for the device, not the device for the reader";
  EXPECT_EQ(report.stages[1].latency.count, 10u);
  EXPECT_EQ(report.stages[1].latency.max, 3ms);
  EXPECT_EQ(report.stages[2].latency.max, 50ms);
  EXPECT_LT(report.stages[2].latency.p50, 3ms);
  EXPECT_EQ(report.latency.max, 53ms);
  EXPECT_NEAR(to_seconds(report.latency.p50), 0.005, 0.0001);
}

}  // namespace
}  // namespace choreo::pipeline
