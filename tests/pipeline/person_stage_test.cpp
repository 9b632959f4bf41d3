// SPDX-License-Identifier: Apache-2.0
// When people are looked for, and when what was seen takes effect.
#include "pipeline/stages/person_stage.hpp"

#include <chrono>
#include <memory>
#include <set>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "pipeline/fakes.hpp"
#include "pipeline/runner.hpp"
#include "support/frames.hpp"
#include "vision/tiny_pose.hpp"

namespace choreo::pipeline {
namespace {

constexpr auto kFrame = std::chrono::milliseconds(40);

// Somebody is there in the frames for which that is said; the picture is 224 x 224.
std::vector<devices::FramePtr> frames_of(int count, const std::function<bool(int)>& somebody,
                                         const std::set<std::uint64_t>& late = {}) {
  std::vector<devices::FramePtr> frames;
  const cv::Mat nobody(224, 224, CV_8UC3, cv::Scalar());
  const cv::Mat body = nobody.clone();
  body(cv::Rect(100, 100, 24, 24)).setTo(cv::Scalar::all(255));
  for (int i = 0; i < count; ++i) {
    auto frame = std::make_shared<devices::Frame>();
    frame->sequence = std::uint64_t(i);
    frame->device_time = i * Nanoseconds(kFrame);
    frame->bgr = somebody(i) ? body : nobody;
    frame->late_person = late.contains(frame->sequence);
    frames.push_back(frame);
  }
  return frames;
}

bool always(int) { return true; }

struct Known {
  bool looked = false, somebody = false;
  Nanoseconds seen_at{0};
  cv::Point2d nose;
  bool operator==(const Known&) const = default;
};

Known known(const Observation& o) {
  Known out{o.looked.has_value(), o.person != nullptr, {}, {}};
  if (o.person) {
    out.seen_at = o.person->time;
    out.nose = o.person->look.points[0].at;
  }
  return out;
}

std::vector<Known> all_known(PersonStage& stage, const std::vector<devices::FramePtr>& frames) {
  std::vector<Known> all;
  for (const auto& frame : frames) {
    Observation observation;
    observation.frame = frame;
    observation.time = frame->device_time;
    stage.process(observation);
    all.push_back(known(observation));
  }
  return all;
}

PersonStageOptions looking(double per_s, int delay) {
  PersonStageOptions options;
  options.looks_per_s = per_s;
  options.delay_s = delay * to_seconds(kFrame);
  return options;
}

TEST(PersonStage, LooksSoOftenByTheFramesTimesAndTakesEffectAtOnceWithoutADelay) {
  PersonStage stage(test::tiny_search(), looking(10, 0));  // 25 frames a second.
  const auto all = all_known(stage, frames_of(10, always));
  for (int i = 0; i < 10; ++i) {
    const auto& k = all[std::size_t(i)];
    // At 0, 0.1, 0.2, 0.3 s, or the first frame behind it.
    const bool looked = i == 0 || i == 3 || i == 5 || i == 8;
    EXPECT_EQ(k.looked, looked) << i;
    EXPECT_TRUE(k.somebody) << i;
    if (looked) {
      EXPECT_EQ(k.seen_at, i * Nanoseconds(kFrame)) << i;
    }
  }
  EXPECT_EQ(stage.looks(), 4u);
  EXPECT_EQ(stage.seen(), 4u);
}

TEST(PersonStage, NoFrameIsLookedAtTwice) {
  PersonStage stage(test::tiny_search(), looking(1000, 0));
  (void)all_known(stage, frames_of(5, always));
  EXPECT_EQ(stage.looks(), 5u);
}

TEST(PersonStage, BesideTheFramesItTakesEffectSoManyFramesLaterAndThenLooksAgain) {
  for (const int delay : {1, 4}) {
    PersonStage stage(test::tiny_search(), looking(1000, delay));
    const auto all = all_known(stage, frames_of(12, always));
    for (int i = 0; i < 12; ++i) {
      const auto& k = all[std::size_t(i)];
      EXPECT_EQ(k.somebody, i >= delay) << i;
      EXPECT_EQ(k.looked, i > 0 && i % delay == 0) << i;
      if (k.looked) {
        EXPECT_EQ(k.seen_at, (i - delay) * Nanoseconds(kFrame)) << i;
      }
    }
  }
}

TEST(PersonStage, WhoLeavesIsThereUntilALookSawThatTheyAreNot) {
  PersonStage stage(test::tiny_search(), looking(1000, 2));
  const auto all = all_known(stage, frames_of(10, [](int i) { return i < 5; }));
  // Looks at 0, 2, 4 and 6.
  for (int i = 0; i < 10; ++i) EXPECT_EQ(all[std::size_t(i)].somebody, i >= 2 && i < 8) << i;
  EXPECT_TRUE(all[8].looked);
}

TEST(PersonStage, JointsAreInPixelsOfTheObservationsPicture) {
  for (const int reduced : {224, 112}) {
    PersonStage stage(test::tiny_search(), looking(10, 0));
    Observation o;
    o.frame = frames_of(1, always)[0];
    cv::resize(o.frame->bgr, o.picture, {reduced, reduced});
    stage.process(o);
    ASSERT_TRUE(o.person);
    const auto& look = o.person->look;
    // The middle of the square, and the nose 40 of 256 of the region above it.
    EXPECT_NEAR(look.region.centre.x, (reduced - 1) / 2.0, 0.01);
    EXPECT_NEAR(look.points[0].at.x, (reduced - 1) / 2.0, 0.01);
    EXPECT_NEAR(look.points[0].at.y, (reduced - 1) / 2.0 - look.region.side * 40 / 256, 0.01);
    EXPECT_NEAR(look.points[0].depth, -5 * look.region.side / 256, 0.01);
  }
}

TEST(PersonStage, FramesWithoutAPictureAreNotLookedAt) {
  PersonStage stage(test::tiny_search(), looking(1000, 0));
  Observation o;
  o.frame = std::make_shared<devices::Frame>();
  stage.process(o);
  EXPECT_FALSE(o.looked);
  EXPECT_EQ(stage.looks(), 0u);
}

// A look takes longer than no time at all: at once it is late, and takes effect at the first frame behind its end.
TEST(PersonStage, ALateLookTakesEffectLaterAndAReplayThatIsToldOfItGivesTheSame) {
  std::set<std::uint64_t> late;
  auto options = looking(1000, 1);
  options.waits = false;
  options.on_late = [&](std::uint64_t sequence) { late.insert(sequence); };
  const auto somebody = [](int i) { return i % 90 < 60; };
  constexpr int kLeast = 200, kMost = 10000;  // Frames; a machine may be busy.
  PersonStage live(test::tiny_search(), options);
  std::vector<Known> was;
  for (const auto& frame : frames_of(kMost, somebody)) {
    was.push_back(all_known(live, {frame})[0]);
    if (int(was.size()) >= kLeast && live.looks() > 2) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_GT(live.looks(), 2u) << "what is late is not lost";
  EXPECT_GT(late.size(), 0u);
  PersonStage replay(test::tiny_search(), looking(1000, 1));
  EXPECT_EQ(all_known(replay, frames_of(int(was.size()), somebody, late)), was);
  EXPECT_EQ(replay.looks(), live.looks());
}

TEST(PersonStage, OneThreadOrManyGiveTheSame) {
  const auto with_threads = [](int threads) {
    std::vector<std::unique_ptr<Stage>> stages;
    std::vector<Known> all;
    stages.push_back(std::make_unique<PersonStage>(test::tiny_search(), looking(10, 3)));
    stages.push_back(
        std::make_unique<test::FunctionStage>("collect", [&](Observation& o) { all.push_back(known(o)); }));
    test::ListedSource source(frames_of(40, [](int i) { return i % 9 < 6; }));
    const test::SimulatedClock clock;
    RunnerOptions options;
    options.threads = threads;
    EXPECT_FALSE(run(source, {}, stages, options, clock, {}).problem);
    return all;
  };
  const auto one = with_threads(1);
  EXPECT_EQ(one.size(), 40u);
  EXPECT_EQ(one, with_threads(0));
}

TEST(PersonStage, SettingsOutOfRangeAreRefused) {
  for (const auto& bad : {looking(0.05, 1), looking(1001, 1), looking(10, -1), looking(10, 61)}) {
    const auto error = test::error_of([&] { PersonStage stage(test::tiny_search(), bad); });
    ASSERT_TRUE(error);
    EXPECT_EQ(error->fault(), Fault::kUsage);
  }
}

}  // namespace
}  // namespace choreo::pipeline
