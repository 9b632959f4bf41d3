// SPDX-License-Identifier: Apache-2.0
#include "pipeline/stages/face_stage.hpp"

#include <algorithm>
#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "pipeline/core_limit.hpp"
#include "pipeline/fakes.hpp"
#include "pipeline/runner.hpp"
#include "support/frames.hpp"

namespace choreo::pipeline {
namespace {

using vision::Face;

// Finds what a function says, in coordinates of the part that it is given.
class FakeDetector final : public vision::FaceDetector {
 public:
  using Find = std::function<std::vector<Face>(const cv::Mat& grey)>;
  explicit FakeDetector(Find find) : find_(std::move(find)) {}
  std::vector<Face> detect(const cv::Mat& grey, const cv::Rect&, double, double, vision::FaceLook) override {
    return find_(grey);
  }

 private:
  Find find_;
};

// The brightest pixel's surroundings.
std::vector<Face> brightest(const cv::Mat& grey) {
  double most = 0;
  cv::Point at;
  cv::minMaxLoc(grey, nullptr, &most, nullptr, &at);
  if (most < 200) return {};
  return {{{at.x - 9.5, at.y - 9.5, 20, 20}, 0.5}};
}

constexpr auto kFrame = std::chrono::milliseconds(40);

// A bright spot that moves to the right by a pixel a frame.
std::vector<devices::FramePtr> moving_spot(int count, const std::set<std::uint64_t>& late = {}) {
  std::vector<devices::FramePtr> frames;
  for (int i = 0; i < count; ++i) {
    cv::Mat picture = cv::Mat::zeros(120, 160, CV_8UC3);
    picture(cv::Rect(40 + i % 80, 50, 1, 1)).setTo(cv::Scalar::all(255));
    auto frame = std::make_shared<devices::Frame>();
    frame->sequence = std::uint64_t(i);
    frame->device_time = i * Nanoseconds(kFrame);
    frame->bgr = picture;
    frame->late_face = late.contains(frame->sequence);
    frames.push_back(frame);
  }
  return frames;
}

Observation observation_of(const devices::FramePtr& frame) {
  Observation observation;
  observation.frame = frame;
  observation.time = frame->device_time;
  return observation;
}

struct Known {
  bool face = false;
  double x = 0, y = 0, width = 0, confidence = 0, unseen_s = 0;
  int faces = 0;
  bool operator==(const Known&) const = default;
};

Known known(const Observation& o) {
  if (!o.face) return {.faces = o.faces};
  return {true, o.face->centre.x, o.face->centre.y, o.face->width, o.face->confidence, o.face->unseen_s, o.faces};
}

std::vector<Known> all_known(FaceStage& stage, const std::vector<devices::FramePtr>& frames) {
  std::vector<Known> all;
  for (const auto& frame : frames) {
    auto observation = observation_of(frame);
    stage.process(observation);
    all.push_back(known(observation));
  }
  return all;
}

FaceStageOptions at_once(int delay = 3) {
  FaceStageOptions options;
  options.track.persistence = 1;
  options.delay_frames = delay;
  options.rows = 120;  // As the spot's frames have.
  return options;
}

TEST(FaceStage, WhatIsAskedAtAFrameTakesEffectSoManyFramesLater) {
  for (const int delay : {1, 3, 10}) {
    FaceStage stage(std::make_unique<FakeDetector>(brightest), at_once(delay));
    const auto all = all_known(stage, moving_spot(20));
    for (int i = 0; i < delay; ++i) EXPECT_FALSE(all[std::size_t(i)].face) << i;
    const auto& first = all[std::size_t(delay)];
    ASSERT_TRUE(first.face);
    EXPECT_NEAR(first.unseen_s, delay * to_seconds(Nanoseconds(kFrame)), 1e-9);
    EXPECT_NEAR(first.x, 40.5 + delay, 1e-9) << "where the spot is by now";
    EXPECT_NEAR(first.width, 20, 1e-9);
    EXPECT_EQ(first.faces, 1);
  }
}

// Eyes and mouth about a place, and a person of 200 px a metre.
std::shared_ptr<const PersonSighting> person_at(cv::Point2d face, Nanoseconds time, double visibility = 1) {
  auto sighting = std::make_shared<PersonSighting>();
  sighting->time = time;
  auto& look = sighting->look;
  look.score = 1;
  for (std::size_t k = 0; k < vision::kPersonPoints; ++k) {
    const bool of_face = k <= 10;
    const cv::Point2d metres =
        of_face ? cv::Point2d(k % 2 == 0 ? 0.02 : -0.02, -0.6) : cv::Point2d(0, 0.1 * double(k % 9));
    look.metres[k] = {metres.x, metres.y, k == 0 ? -0.1 : 0};  // The nose is before the ears.
    look.points[k] = {face + 200 * (metres - cv::Point2d(0, -0.6)), 0, visibility, 1};
  }
  return sighting;
}

TEST(FaceStage, TheFaceThatThePersonNetworkSeesIsThePerformersAndNothingIsSearched) {
  FaceStage stage(std::make_unique<FakeDetector>(brightest), at_once());
  for (const auto& frame : moving_spot(12)) {
    auto o = observation_of(frame);
    o.person = person_at({30.0 + double(frame->sequence), 20}, o.time);
    stage.process(o);
    ASSERT_EQ(o.face.has_value(), frame->sequence > 0) << "two looks in a row";
    if (!o.face) continue;
    EXPECT_NEAR(o.face->centre.x, 30.0 + double(frame->sequence), 2) << "eyes and mouth are 2 % of a metre aside";
    EXPECT_NEAR(o.face->centre.y, 20, 1e-6);
    EXPECT_NEAR(o.face->width, 0.16 * 200, 0.5);
    EXPECT_EQ(o.faces, 1);
    EXPECT_EQ(o.face->unseen_s, 0);
  }
  EXPECT_EQ(stage.asked(), 0u);
}

TEST(FaceStage, BetweenLooksTheFaceGoesOnAsItWent) {
  FaceStage stage(std::make_unique<FakeDetector>(brightest), at_once());
  const auto frames = moving_spot(8);
  std::vector<double> x;
  for (const auto& frame : frames) {
    auto o = observation_of(frame);
    // A look every other frame.
    const auto looked = frame->sequence / 2 * 2;
    o.person = person_at({30.0 + 4 * double(looked), 20}, frames[looked]->device_time);
    stage.process(o);
    if (o.face) x.push_back(o.face->centre.x - 30);
  }
  ASSERT_EQ(x.size(), 6u);
  EXPECT_NEAR(x[1] - x[0], 4, 0.6);
  EXPECT_NEAR(x[3] - x[2], 4, 0.6);
  EXPECT_NEAR(x[5] - x[4], 4, 0.6);
}

TEST(FaceStage, WhereTheNetworkSeesTheBackOfTheHeadThereIsNoFace) {
  FaceStage stage(std::make_unique<FakeDetector>(brightest), at_once());
  for (const auto& frame : moving_spot(12)) {
    auto o = observation_of(frame);
    auto person = std::make_shared<PersonSighting>(*person_at({30, 20}, o.time));
    person->look.metres[std::size_t(vision::PersonPointName::kNose)].z = 0.1;  // Behind the ears.
    o.person = person;
    stage.process(o);
    EXPECT_FALSE(o.face);
  }
  EXPECT_EQ(stage.asked(), 0u);
}

// Four frames lie between the one that was looked at and the one that knows, and it goes to and fro meanwhile.
TEST(FaceStage, BetweenLooksTheFaceIsFollowedByItsPicture) {
  FaceStage stage(std::make_unique<FakeDetector>(brightest), at_once());
  cv::Mat texture(32, 32, CV_8UC3);
  cv::theRNG().state = 1;
  cv::randu(texture, 0, 256);
  cv::blur(texture, texture, {5, 5});
  std::vector<devices::FramePtr> frames;
  std::vector<cv::Point> truth;
  for (int k = 0; k < 24; ++k) {
    auto frame = std::make_shared<devices::Frame>();
    frame->sequence = std::uint64_t(k);
    frame->device_time = Nanoseconds(k * 33'000'000);
    frame->bgr = cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(120));
    const auto& at = truth.emplace_back(cvRound(160 + 60 * std::sin(0.2 * k)), cvRound(120 + 20 * std::cos(0.4 * k)));
    texture.copyTo(frame->bgr(cv::Rect(at - cv::Point(16, 16), texture.size())));
    frames.push_back(frame);
    auto o = observation_of(frame);
    if (k < 4) continue;
    const auto looked = std::size_t(k / 4 * 4 - 4);
    auto person = std::make_shared<PersonSighting>(*person_at(truth[looked], frames[looked]->device_time));
    person->frame = frames[looked];
    o.person = person;
    stage.process(o);
    if (k < 8) continue;
    ASSERT_TRUE(o.face);
    const cv::Point2d apart = o.face->centre - cv::Point2d(at);
    EXPECT_LT(std::hypot(apart.x, apart.y), 5) << k << ": a sixth of its width";
  }
}

TEST(FaceStage, WhereTheNetworkSeesNoFaceOneIsSearched) {
  FaceStage stage(std::make_unique<FakeDetector>(brightest), at_once());
  Observation last;
  for (const auto& frame : moving_spot(8)) {
    last = observation_of(frame);
    last.person = person_at({100, 20}, last.time, 0.1);
    stage.process(last);
  }
  ASSERT_TRUE(last.face);
  EXPECT_NEAR(last.face->centre.y, 50.5, 1) << "the detector's";
  EXPECT_GT(stage.asked(), 0u);
}

TEST(FaceStage, TheFaceIsGivenInPixelsOfTheObservationsPicture) {
  FaceStage stage(std::make_unique<FakeDetector>(brightest), at_once());
  Observation last;
  for (const auto& frame : moving_spot(4)) {
    last = observation_of(frame);
    cv::resize(frame->bgr, last.picture, {80, 60});
    stage.process(last);
  }
  ASSERT_TRUE(last.face);
  EXPECT_NEAR(last.face->centre.x, 21.75, 1e-9);
  EXPECT_NEAR(last.face->width, 10, 1e-9);
}

TEST(FaceStage, FramesAreSearchedAtNoMoreRowsThanAskedFor) {
  for (const auto& [asked, searched] : {std::pair{480, 120}, {120, 120}, {60, 60}}) {
    auto options = at_once();
    options.rows = asked;
    int rows = 0;
    {
      FaceStage stage(std::make_unique<FakeDetector>([&](const cv::Mat& grey) {
                        rows = std::max(rows, grey.rows);
                        return std::vector<Face>{};
                      }),
                      options);
      (void)all_known(stage, moving_spot(20));
    }
    // Searches are of parts of the picture, by and by of nearly all of its rows.
    EXPECT_LE(rows, searched) << asked;
    EXPECT_GT(rows, searched * 2 / 3) << asked;
  }
}

TEST(FaceStage, OneThreadOrManyGiveTheSame) {
  const auto with_threads = [](int threads) {
    std::vector<std::unique_ptr<Stage>> stages;
    std::vector<Known> all;
    stages.push_back(std::make_unique<FaceStage>(std::make_unique<FakeDetector>(brightest), at_once()));
    stages.push_back(
        std::make_unique<test::FunctionStage>("collect", [&](Observation& o) { all.push_back(known(o)); }));
    test::ListedSource source(moving_spot(100));
    const test::SimulatedClock clock;
    RunnerOptions options;
    options.threads = threads;
    EXPECT_FALSE(run(source, {}, stages, options, clock, {}).problem);
    return all;
  };
  const auto one = with_threads(1);
  EXPECT_EQ(one.size(), 100U);
  EXPECT_EQ(one, with_threads(0));
}

TEST(FaceStage, LiveADetectionThatIsNotReadyIsVoidAndNoted) {
  std::promise<void> go;
  auto gone = go.get_future().share();
  std::vector<std::uint64_t> late;
  auto options = at_once();
  options.waits = false;
  options.on_late = [&](std::uint64_t sequence) { late.push_back(sequence); };
  FaceStage stage(std::make_unique<FakeDetector>([gone](const cv::Mat& grey) {
                    gone.wait();
                    return brightest(grey);
                  }),
                  options);
  const auto all = all_known(stage, moving_spot(10));
  for (const auto& one : all) EXPECT_FALSE(one.face);
  ASSERT_FALSE(late.empty());
  EXPECT_EQ(late.front(), 3U) << "asked at frame 0, due at frame 3";
  EXPECT_EQ(stage.late(), late.size());
  go.set_value();
}

// Whatever was late, for whatever reason, the replay that is told of it gives the same.
TEST(FaceStage, AReplayThatVoidsTheSameDetectionsGivesTheSame) {
  std::promise<void> go;
  auto gone = go.get_future().share();
  std::set<std::uint64_t> late;
  auto options = at_once();
  options.waits = false;
  options.on_late = [&](std::uint64_t sequence) { late.insert(sequence); };
  std::vector<Known> live;
  {
    FaceStage stage(std::make_unique<FakeDetector>([gone](const cv::Mat& grey) {
                      gone.wait();
                      return brightest(grey);
                    }),
                    options);
    const auto frames = moving_spot(200);
    for (const auto& frame : frames) {
      if (frame->sequence == 20) go.set_value();
      auto observation = observation_of(frame);
      stage.process(observation);
      live.push_back(known(observation));
    }
  }
  EXPECT_FALSE(late.empty());
  std::set<std::uint64_t> late_again;
  options.waits = true;
  options.on_late = [&](std::uint64_t sequence) { late_again.insert(sequence); };
  FaceStage stage(std::make_unique<FakeDetector>(brightest), options);
  EXPECT_EQ(all_known(stage, moving_spot(200, late)), live);
  EXPECT_EQ(late_again, late);
}

TEST(FaceStage, AnErrorOfTheDetectorEndsTheRunWithItsMessageWhenItIsDue) {
  const auto message = [](FakeDetector::Find find) {
    FaceStage stage(std::make_unique<FakeDetector>(std::move(find)), at_once());
    const auto frames = moving_spot(10);
    for (std::size_t i = 0; i < 3; ++i) {
      auto observation = observation_of(frames[i]);
      stage.process(observation);
    }
    auto observation = observation_of(frames[3]);
    const auto error = test::error_of([&] { stage.process(observation); });
    return error ? std::string(error->what()) : std::string();
  };
  EXPECT_EQ(message([](const cv::Mat&) -> std::vector<Face> { throw failure("no luck"); }), "no luck");
  EXPECT_EQ(message([](const cv::Mat&) -> std::vector<Face> { throw cv::Exception(-1, "too bad", "", "", 1); }),
            "searching for faces failed: too bad");
}

// OpenCV's guard against loops within loops is one flag of the process: it may be another thread's, and be gone.
TEST(FaceStage, ASearchTakesOneCoreWhateverOtherThreadsDoInOpenCv) {
  const CoreLimit cores(4);
  std::promise<void> flag_is_up;
  std::promise<void> search_began;
  std::promise<void> flag_is_down;
  const auto up = flag_is_up.get_future();
  std::thread other([&] {
    cv::parallel_for_({0, 1}, [&](const cv::Range&) {
      flag_is_up.set_value();
      search_began.get_future().wait();
    });
    flag_is_down.set_value();
  });
  std::mutex mutex;
  std::set<std::thread::id> searching;
  const auto search = [&](const cv::Mat&) {
    search_began.set_value();
    flag_is_down.get_future().wait();
    cv::parallel_for_({0, 256}, [&](const cv::Range& parts) {
      for (int i = parts.start; i < parts.end; ++i) {
        const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(200);
        while (std::chrono::steady_clock::now() < end) {
        }
        const std::scoped_lock lock(mutex);
        searching.insert(std::this_thread::get_id());
      }
    });
    return std::vector<Face>{};
  };
  up.wait();
  {
    FaceStage stage(std::make_unique<FakeDetector>(search), at_once());
    auto observation = observation_of(moving_spot(1).front());
    stage.process(observation);
    other.join();  // The search has begun.
  }
  EXPECT_EQ(searching.size(), 1u);
}

TEST(FaceStage, EmptyPicturesHaveNoFaceAndTinyOnesNoneBesideThem) {
  FaceStage stage(std::make_unique<FakeDetector>(brightest), at_once());
  int faces = 0;
  for (const cv::Mat& picture : {cv::Mat(), cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(255))}) {
    for (std::uint64_t i = 0; i < 8; ++i) {
      auto observation = observation_of(test::frame_at(i, Nanoseconds(i * 1000000), picture));
      stage.process(observation);
      if (!observation.face) continue;
      ++faces;
      ASSERT_FALSE(picture.empty());
      EXPECT_TRUE(cv::Rect2d(0, 0, 1, 1).contains(observation.face->centre)) << observation.face->centre;
    }
  }
  EXPECT_GT(faces, 0) << "the detector finds one wherever it is asked to look";
}

TEST(FaceStage, ItsEndEndsTheThreadWhateverIsStillAskedFor) {
  FaceStage stage(std::make_unique<FakeDetector>(brightest), at_once(60));
  (void)all_known(stage, moving_spot(30));
  EXPECT_GT(stage.asked(), 5U);
}

TEST(FaceStage, SettingsOutOfRangeAreRefused) {
  const auto refused = [](auto change) {
    FaceStageOptions options;
    change(options);
    EXPECT_THROW(options.validate(), Error);
  };
  refused([](auto& o) { o.delay_frames = 0; });
  refused([](auto& o) { o.rows = 10; });
  refused([](auto& o) { o.search.least_share = 2; });
  refused([](auto& o) { o.track.persistence = 0; });
}

}  // namespace
}  // namespace choreo::pipeline
