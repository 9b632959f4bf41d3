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

TEST(PersonStage, LooksForArmsAreFewer) {
  auto options = looking(1000, 0);
  options.arms_per_s = 10;
  PersonStage stage(test::tiny_search(), options);
  const auto frames = frames_of(6, always);
  for (int i = 0; i < 6; ++i) {
    Observation o;
    o.frame = frames[std::size_t(i)];
    o.time = o.frame->device_time;
    stage.process(o);
    ASSERT_TRUE(o.person) << i;
    const bool for_arms = i == 0 || i == 3 || i == 5;  // At 0, 0.1, 0.2 s, or the first frame behind it.
    EXPECT_EQ(o.person->arms.has_value(), for_arms) << i;
  }
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

// Frames of 672 x 224, in which the search finds who is at the left or at the right.
struct Sides {
  bool left = false, right = false;
};

std::vector<Observation> all_seen(PersonStage& stage, const std::vector<Sides>& frames, int reduced = 224) {
  std::vector<Observation> all;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    auto frame = std::make_shared<devices::Frame>();
    frame->sequence = i;
    frame->device_time = Nanoseconds(kFrame) * int(i);
    frame->bgr = cv::Mat(224, 672, CV_8UC3, cv::Scalar());
    if (frames[i].left) frame->bgr(cv::Rect(100, 100, 24, 24)).setTo(cv::Scalar::all(255));
    if (frames[i].right) frame->bgr(cv::Rect(548, 100, 24, 24)).setTo(cv::Scalar::all(255));
    auto& o = all.emplace_back();
    o.frame = frame;
    o.time = frame->device_time;
    if (reduced != 224) cv::resize(frame->bgr, o.picture, {3 * reduced, reduced});
    stage.process(o);
  }
  return all;
}

TEST(PersonStage, OthersStayForASecondWhileThePersonIsLostAndAreThenWhoIsFound) {
  PersonStage stage(test::tiny_search(), looking(1000, 0));
  std::vector<Sides> frames(40, {false, true});
  frames[0] = frames[1] = {true, true};
  const auto all = all_seen(stage, frames, 112);
  for (const int i : {0, 1}) {
    const auto& o = all[std::size_t(i)];
    ASSERT_TRUE(o.person);
    ASSERT_EQ(o.others.size(), 1u);
    EXPECT_NEAR(o.person->look.region.centre.x, 55.5, 1) << "in pixels of the reduced picture";
    EXPECT_NEAR(o.others[0]->look.region.centre.x, 279.5, 1);
  }
  // The last look that saw the person was at 40 ms.
  for (std::size_t i = 2; i <= 26; ++i) {
    EXPECT_FALSE(all[i].person) << i << ": who was another is not the person";
    EXPECT_EQ(all[i].others.size(), 1u) << i;
  }
  EXPECT_FALSE(all[27].person);
  EXPECT_TRUE(all[27].others.empty());
  ASSERT_TRUE(all[28].person);
  EXPECT_NEAR(all[28].person->look.region.centre.x, 279.5, 1);
  EXPECT_TRUE(all[28].others.empty());
}

TEST(PersonStage, OthersAreNotLookedForWhereTheyAreNotWanted) {
  auto options = looking(1000, 0);
  options.others = false;
  PersonStage stage(test::tiny_search(), options);
  const auto all = all_seen(stage, {{true, true}, {true, true}});
  EXPECT_TRUE(all[1].person);
  EXPECT_TRUE(all[1].others.empty());
}

TEST(PersonStage, FilteredJointsBeginAnewWithWhoeverWasNotFollowed) {
  for (const bool lost : {false, true}) {
    auto options = looking(1000, 0);
    options.others = false;
    options.smooth = vision::JointFilterOptions{0.1, 0};  // So slow that who is filtered hardly moves.
    PersonStage stage(test::tiny_search(), options);
    std::vector<Sides> frames = {{true, false}, {true, false}};
    if (lost) frames.push_back({});
    frames.push_back({false, true});
    const auto all = all_seen(stage, frames, 112);
    EXPECT_EQ(all[2].person == nullptr, lost);
    ASSERT_TRUE(all.back().person);
    ASSERT_TRUE(all.back().person->smooth);
    EXPECT_NEAR(all.back().person->smooth->points[0].at.x, 279.5, 1) << lost;
    EXPECT_FALSE(all.back().person->speed) << "nobody went from one side to the other";
    // Who is followed is looked at more and more closely, and so the nose comes nearer: with the filter hardly.
    const double raw = all[1].person->look.points[0].at.y - all[0].person->look.points[0].at.y;
    const double smooth = all[1].person->smooth->points[0].at.y - all[0].person->smooth->points[0].at.y;
    EXPECT_GT(raw, 0.5);
    EXPECT_LT(smooth, raw / 4);
    EXPECT_GT(smooth, 0);
  }
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
