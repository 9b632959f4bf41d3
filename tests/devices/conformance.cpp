// SPDX-License-Identifier: Apache-2.0
#include "devices/conformance.hpp"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include <gmock/gmock.h>
#include <opencv2/core.hpp>

#include "core/error.hpp"
#include "support/eventually.hpp"
#include "support/frames.hpp"

namespace choreo::devices {
namespace {

using namespace std::chrono_literals;
using SteadyTime = std::chrono::steady_clock;

std::vector<ConformanceCase> subjects_of(ConformanceKind kind) {
  auto all = conformance_subjects();
  std::erase_if(all, [&](const ConformanceCase& one) { return one.kind != kind; });
  return all;
}

class Conformance : public ::testing::TestWithParam<ConformanceCase> {
 protected:
  void SetUp() override {
    subject_.emplace(GetParam().make());
    registry_.add(subject_->driver);
  }

  std::unique_ptr<Source> open() {
    OpenOptions options;
    options.on_event = [this](const DeviceEvent& event) {
      const std::scoped_lock lock(mutex_);
      events_.push_back(event);
      if (awaited_ == event.state) stop_.request_stop();
    };
    return registry_.open(subject_->source, options);
  }

  // Reads until the state was entered, some seconds at most. @return when it was.
  std::optional<Nanoseconds> read_until(Source& source, DeviceState state) {
    stop_ = std::stop_source();
    awaited_ = state;
    const std::jthread patience([stop = stop_](const std::stop_token& over) mutable {
      std::mutex mutex;
      std::unique_lock lock(mutex);
      std::condition_variable_any never;
      never.wait_for(lock, over, 20s, [] { return false; });
      stop.request_stop();
    });
    const auto found = [&]() -> std::optional<Nanoseconds> {
      for (; asked_for_ < events_.size(); ++asked_for_) {
        if (events_[asked_for_].state == state) return events_[asked_for_++].at;
      }
      return std::nullopt;
    };
    auto at = found();
    while (!at && !stop_.stop_requested()) {
      check(source.read(stop_.get_token()));
      at = found();
    }
    awaited_.reset();
    return at;
  }

  // Numbers and times go on, across losses too.
  void check(const FramePtr& frame) {
    if (!frame) return;
    if (last_) {
      EXPECT_GT(frame->sequence, last_->sequence);
      EXPECT_GT(frame->device_time, last_->device_time);
    }
    last_ = frame;
  }

  std::optional<ConformanceSubject> subject_;
  Registry registry_;
  std::mutex mutex_;
  std::vector<DeviceEvent> events_;
  std::optional<DeviceState> awaited_;  // Stops `stop_`.
  std::stop_source stop_;
  std::size_t asked_for_ = 0;
  FramePtr last_;
};

// What only recordings promise, and only what can go away.
class RecordingConformance : public Conformance {};
class CameraConformance : public Conformance {};
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(RecordingConformance);
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(CameraConformance);

TEST_P(Conformance, FramesAreWhatWasPromised) {
  const auto source = open();
  const auto& info = source->info();
  EXPECT_EQ(info.repeatable, GetParam().kind == ConformanceKind::kRecording);
  EXPECT_EQ(bool(subject_->lose), GetParam().kind == ConformanceKind::kCamera);
  EXPECT_FALSE(info.name.empty());
  EXPECT_GE(info.nominal_fps, 0);
  for (int k = 0; k < 10; ++k) {
    const auto frame = source->read({});
    ASSERT_TRUE(frame) << "frame " << k;
    EXPECT_EQ(frame->bgr.size(), info.size);
    EXPECT_EQ(frame->bgr.type(), CV_8UC3);
    if (!frame->depth.empty()) {
      EXPECT_EQ(frame->depth.size(), info.size);
      EXPECT_EQ(frame->depth.type(), CV_16UC1);
    }
    check(frame);
  }
}

TEST_P(Conformance, AFrameStaysAsItIsWhileLaterOnesAreRead) {
  const auto source = open();
  const auto first = source->read({});
  ASSERT_TRUE(first);
  const cv::Mat colours = first->bgr.clone();
  const cv::Mat depth = first->depth.clone();
  for (int k = 0; k < 8; ++k) ASSERT_TRUE(source->read({}));
  EXPECT_EQ(cv::norm(colours, first->bgr, cv::NORM_INF), 0);
  if (!depth.empty()) {
    EXPECT_EQ(cv::norm(depth, first->depth, cv::NORM_INF), 0);
  }
}

TEST_P(Conformance, StartsAndStopsAsOftenAsAnybodyLikes) {
  for (int k = 0; k < 5; ++k) {
    const auto source = open();
    ASSERT_TRUE(source->read({})) << "start " << k;
  }
}

TEST_P(Conformance, MayBeDestroyedBeforeItsFirstFrame) {
  const auto begin = SteadyTime::now();
  for (int k = 0; k < 3; ++k) (void)open();
  EXPECT_LT(SteadyTime::now() - begin, 15s);
  EXPECT_TRUE(open()->read({}));
}

TEST_P(Conformance, AStopThatNobodyNeededChangesNothing) {
  const auto source = open();
  std::stop_source stop;
  stop.request_stop();
  check(source->read(stop.get_token()));
  check(source->read(stop.get_token()));
  for (int k = 0; k < 3; ++k) {
    const auto frame = source->read({});
    ASSERT_TRUE(frame);
    check(frame);
  }
}

TEST_P(Conformance, AStopEndsAWaitSoon) {
  const auto source = open();
  std::stop_source stop;
  std::atomic<int> read{0};
  std::jthread reader([&] {
    while (!stop.stop_requested()) {
      if (source->read(stop.get_token())) ++read;
    }
  });
  ASSERT_TRUE(test::eventually([&] { return read >= 3; }));
  const auto begin = SteadyTime::now();
  stop.request_stop();
  reader.join();
  EXPECT_LT(SteadyTime::now() - begin, 1s);
}

TEST_P(Conformance, ASlowReaderGetsFramesInOrder) {
  const auto source = open();
  for (int k = 0; k < 4; ++k) {
    std::this_thread::sleep_for(250ms);
    const auto frame = source->read({});
    ASSERT_TRUE(frame);
    check(frame);
    if (source->info().repeatable) {
      EXPECT_EQ(frame->sequence, std::uint64_t(k)) << "of a recording nothing is lost";
    }
  }
}

TEST_P(Conformance, AWrongModeIsRefusedInOneLine) {
  const auto error = test::error_of([&] { (void)registry_.open(subject_->wrong_mode); });
  ASSERT_TRUE(error) << subject_->wrong_mode << " was opened";
  EXPECT_EQ(error->fault(), Fault::kUsage);
  EXPECT_EQ(std::string(error->what()).find('\n'), std::string::npos);
  EXPECT_FALSE(error->hint().empty()) << "what would be right";
}

TEST_P(RecordingConformance, WhatCanBeReadAgainIsTheSameAgain) {
  const auto source = open();
  const auto again = open();
  for (int k = 0; k < 5; ++k) {
    const auto a = source->read({});
    const auto b = again->read({});
    ASSERT_TRUE(a && b);
    EXPECT_EQ(a->sequence, b->sequence);
    EXPECT_EQ(a->device_time, b->device_time);
    EXPECT_EQ(cv::norm(a->bgr, b->bgr, cv::NORM_INF), 0);
    if (!a->depth.empty()) {
      EXPECT_EQ(cv::norm(a->depth, b->depth, cv::NORM_INF), 0);
    }
  }
}

TEST_P(CameraConformance, LostAndFound) {
  const auto source = open();
  ASSERT_TRUE(read_until(*source, DeviceState::kRunning));
  for (int turn = 0; turn < 2; ++turn) {
    const auto before = Nanoseconds(SteadyTime::now().time_since_epoch());
    subject_->lose();
    const auto lost = read_until(*source, DeviceState::kLost);
    ASSERT_TRUE(lost) << "not seen to be lost";
    EXPECT_LT(*lost - before, 1s);
    subject_->find();
    ASSERT_TRUE(read_until(*source, DeviceState::kRunning)) << "not taken up again";
    check(source->read({}));
  }
  EXPECT_THAT(source->warnings(), testing::Contains(testing::HasSubstr("was lost 2 times")));
}

TEST_P(CameraConformance, MayBeDestroyedWhileItIsLost) {
  // At several moments of an attempt to take it up again.
  for (const auto later : {0ms, 60ms, 300ms}) {
    auto source = open();
    last_.reset();
    ASSERT_TRUE(read_until(*source, DeviceState::kRunning));
    subject_->lose();
    ASSERT_TRUE(read_until(*source, DeviceState::kLost));
    std::stop_source stop;
    auto begin = SteadyTime::now();
    std::jthread other([&] {
      std::this_thread::sleep_for(later);
      begin = SteadyTime::now();
      stop.request_stop();
    });
    EXPECT_FALSE(source->read(stop.get_token()));
    other.join();
    source.reset();
    EXPECT_LT(SteadyTime::now() - begin, 1s) << "stopped " << later.count() << " ms after the loss";
    subject_->find();
  }
  EXPECT_EQ(events_.back().state, DeviceState::kStopped);
}

std::string name_of_case(const ::testing::TestParamInfo<ConformanceCase>& one) { return one.param.name; }

INSTANTIATE_TEST_SUITE_P(Drivers, Conformance, ::testing::ValuesIn(conformance_subjects()), name_of_case);
INSTANTIATE_TEST_SUITE_P(Drivers, RecordingConformance, ::testing::ValuesIn(subjects_of(ConformanceKind::kRecording)),
                         name_of_case);
INSTANTIATE_TEST_SUITE_P(Drivers, CameraConformance, ::testing::ValuesIn(subjects_of(ConformanceKind::kCamera)),
                         name_of_case);

}  // namespace
}  // namespace choreo::devices
