// SPDX-License-Identifier: Apache-2.0
// A device that goes away, comes back, stays silent or is another one: what the source makes of it.
#include "devices/device_source.hpp"

#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "core/error.hpp"
#include "support/frames.hpp"

namespace choreo::devices {
namespace {

using std::chrono::milliseconds;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class SimulatedClock final : public Clock {
 public:
  [[nodiscard]] Nanoseconds now() const override { return now_; }
  void advance(Nanoseconds by) { now_ += by; }

 private:
  Nanoseconds now_ = std::chrono::hours(1);
};

/// What a device does when it is asked for a frame.
enum class Act { kFrame, kSilent, kVanish, kDamaged };

/// A device that follows a script, across all the sessions that are opened of it.
struct ScriptedDevice {
  SimulatedClock clock;
  std::deque<Act> acts;
  std::deque<bool> openings;  ///< Whether the next attempts to open succeed; then all do.
  cv::Size size{8, 6};
  double fps = 25;
  Nanoseconds closing{0};  ///< How long it takes.
  std::function<void(const std::stop_token&)> on_open = [](const std::stop_token&) {};
  int opened = 0;
  std::uint32_t counter = 100;
};

class ScriptedSession final : public DeviceSession {
 public:
  explicit ScriptedSession(ScriptedDevice& device) : device_(device) {
    info_.size = device.size;
    info_.nominal_fps = device.fps;
  }
  ~ScriptedSession() override { device_.clock.advance(device_.closing); }
  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  [[nodiscard]] bool stamps_with_host_clock() const override { return true; }
  [[nodiscard]] std::optional<DeviceFrame> wait(Nanoseconds patience) override {
    const auto act = device_.acts.empty() ? Act::kFrame : device_.acts.front();
    if (!device_.acts.empty()) device_.acts.pop_front();
    if (act == Act::kVanish) throw DeviceLost("unplugged");
    if (act == Act::kDamaged) {
      ++damaged_;
      return std::nullopt;
    }
    if (act == Act::kSilent) {
      device_.clock.advance(patience);
      return std::nullopt;
    }
    device_.clock.advance(milliseconds(40));
    return DeviceFrame{device_.counter++, device_.clock.now() - milliseconds(3), device_.clock.now(),
                       cv::Mat(device_.size, CV_8UC3, cv::Scalar(1, 2, 3))};
  }
  [[nodiscard]] std::uint64_t damaged() const override { return damaged_; }

 private:
  ScriptedDevice& device_;
  SourceInfo info_;
  std::uint64_t damaged_ = 0;
};

class DeviceSourceTest : public ::testing::Test {
 protected:
  std::unique_ptr<DeviceSource> open() {
    DeviceOptions options;
    options.retry = retry_;
    options.stop = stop_.get_token();
    options.on_event = [this](const DeviceEvent& event) {
      states_.emplace_back(name_of(event.state));
      events_.push_back(event);
    };
    return std::make_unique<DeviceSource>(
        "scripted:",
        [this](const std::stop_token& stop) -> std::unique_ptr<DeviceSession> {
          if (!device_.openings.empty()) {
            const bool there = device_.openings.front();
            device_.openings.pop_front();
            if (!there) throw DeviceLost("nothing is there");
          }
          device_.on_open(stop);
          ++device_.opened;
          return std::make_unique<ScriptedSession>(device_);
        },
        device_.clock, options);
  }

  ScriptedDevice device_;
  Nanoseconds retry_ = milliseconds(1);
  std::stop_source stop_;
  std::vector<std::string> states_;
  std::vector<DeviceEvent> events_;
};

TEST_F(DeviceSourceTest, StartsRunsAndStops) {
  {
    const auto source = open();
    EXPECT_EQ(source->state(), DeviceState::kStarting);
    for (std::uint64_t k = 0; k < 3; ++k) EXPECT_EQ(source->read({})->sequence, k);
    EXPECT_EQ(source->state(), DeviceState::kRunning);
    EXPECT_TRUE(source->warnings().empty());
  }
  EXPECT_THAT(states_, ElementsAre("starting", "running", "stopped"));
}

TEST_F(DeviceSourceTest, IsNoRecording) {
  const auto source = open();
  EXPECT_FALSE(source->info().repeatable);
  EXPECT_EQ(source->info().name, "scripted:");
  EXPECT_EQ(source->info().size, cv::Size(8, 6));
}

TEST_F(DeviceSourceTest, FramesCarryTheHostsTime) {
  const auto source = open();
  const auto frame = source->read({});
  EXPECT_EQ(frame->device_time, device_.clock.now() - milliseconds(3));
}

TEST_F(DeviceSourceTest, ADeviceThatIsNotThereAtFirstIsRefused) {
  device_.openings = {false};
  const auto error = test::error_of([&] { (void)open(); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->fault(), Fault::kUsage);
  EXPECT_THAT(error->what(), HasSubstr("nothing is there"));
  EXPECT_THAT(states_, ElementsAre("starting", "failed"));
}

TEST_F(DeviceSourceTest, OneThatVanishesIsTakenUpAgainAndTheGapShows) {
  device_.acts = {Act::kFrame, Act::kFrame, Act::kVanish};
  device_.openings = {true, false, false, false, true};
  const auto source = open();
  EXPECT_EQ(source->read({})->sequence, 0U);
  const auto before = source->read({});
  const auto after = source->read({});
  EXPECT_GT(after->sequence, before->sequence + 1);
  EXPECT_GT(after->device_time, before->device_time);
  EXPECT_EQ(device_.opened, 2);
  EXPECT_THAT(states_, ElementsAre("starting", "running", "lost", "running"));
  EXPECT_EQ(events_[2].why, "unplugged");
  EXPECT_THAT(source->warnings(), ElementsAre(HasSubstr("was lost 1 time")));
}

TEST_F(DeviceSourceTest, OneThatStaysSilentIsLostWithinASecond) {
  device_.acts = {Act::kFrame};
  device_.acts.insert(device_.acts.end(), 40, Act::kSilent);
  const auto source = open();
  (void)source->read({});
  const auto silent_since = device_.clock.now();
  (void)source->read({});
  ASSERT_GE(events_.size(), 3U);
  EXPECT_EQ(events_[2].state, DeviceState::kLost);
  EXPECT_THAT(events_[2].why, HasSubstr("no frame for"));
  EXPECT_LE(events_[2].at - silent_since, std::chrono::seconds(1));
  EXPECT_GE(events_[2].at - silent_since, milliseconds(400)) << "a hiccup is no loss";
}

TEST_F(DeviceSourceTest, OneOfFewFramesIsNotSilentBetweenThem) {
  device_.fps = 0.5;
  for (int k = 0; k < 3; ++k) {
    device_.acts.push_back(Act::kFrame);
    device_.acts.insert(device_.acts.end(), 40, Act::kSilent);  // 2 s.
  }
  device_.acts.push_back(Act::kFrame);
  device_.acts.insert(device_.acts.end(), 140, Act::kSilent);  // 7 s.
  const auto source = open();
  for (int k = 0; k < 4; ++k) ASSERT_TRUE(source->read({}));
  EXPECT_THAT(states_, ElementsAre("starting", "running"));
  const auto silent_since = device_.clock.now();
  ASSERT_TRUE(source->read({}));
  ASSERT_GE(events_.size(), 3U);
  EXPECT_GT(events_[2].at - silent_since, std::chrono::seconds(6)) << "three frames";
  EXPECT_LE(events_[2].at - silent_since, milliseconds(6100));
}

TEST_F(DeviceSourceTest, ALossIsToldBeforeTheDeviceIsClosed) {
  device_.acts = {Act::kFrame, Act::kVanish};
  device_.closing = std::chrono::seconds(3);
  const auto source = open();
  ASSERT_TRUE(source->read({}));
  const auto vanished = device_.clock.now();
  ASSERT_TRUE(source->read({}));
  ASSERT_GE(events_.size(), 3U);
  EXPECT_EQ(events_[2].state, DeviceState::kLost);
  EXPECT_EQ(events_[2].at, vanished);
}

TEST_F(DeviceSourceTest, OneThatBreaksBeforeItsFirstFrameIsLeftAloneForAWhile) {
  retry_ = milliseconds(5);
  device_.acts = {Act::kFrame};
  device_.acts.insert(device_.acts.end(), 5, Act::kVanish);
  const auto source = open();
  ASSERT_TRUE(source->read({}));
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_TRUE(source->read({}));
  EXPECT_GE(std::chrono::steady_clock::now() - begin, 4 * retry_);
  EXPECT_EQ(device_.opened, 6);
  EXPECT_THAT(states_, ElementsAre("starting", "running", "lost", "running"));
  EXPECT_THAT(source->warnings(), ElementsAre(HasSubstr("was lost 1 time and taken up again"))) << "it ran once";
}

TEST_F(DeviceSourceTest, OneThatIsStillAwayIsNotSaidToBeBack) {
  device_.acts = {Act::kFrame, Act::kVanish};
  const auto source = open();
  ASSERT_TRUE(source->read({}));
  std::stop_source stop;
  device_.on_open = [&](const std::stop_token&) {
    stop.request_stop();
    throw DeviceLost("nothing is there");
  };
  EXPECT_FALSE(source->read(stop.get_token()));
  EXPECT_THAT(source->warnings(), ElementsAre("scripted: was lost 1 time and is not back"));
}

TEST_F(DeviceSourceTest, OneThatNeverGaveAFrameIsSaidToBeSo) {
  device_.acts = {Act::kVanish};
  const auto source = open();
  std::stop_source stop;
  device_.on_open = [&](const std::stop_token&) {
    stop.request_stop();
    throw DeviceLost("nothing is there");
  };
  EXPECT_FALSE(source->read(stop.get_token()));
  EXPECT_THAT(states_, ElementsAre("starting", "lost"));
  EXPECT_THAT(source->warnings(), ElementsAre("scripted: never gave a frame"));
}

TEST_F(DeviceSourceTest, TheFirstFrameMayTakeLonger) {
  device_.acts.assign(40, Act::kSilent);  // 2 s.
  const auto source = open();
  EXPECT_EQ(source->read({})->sequence, 0U);
  EXPECT_THAT(states_, ElementsAre("starting", "running"));
}

TEST_F(DeviceSourceTest, ADeviceThatComesBackWithOtherPicturesIsNotTaken) {
  device_.acts = {Act::kFrame, Act::kVanish};
  const auto source = open();
  (void)source->read({});
  device_.size = {16, 12};
  std::stop_source stop;
  device_.on_open = [&](const std::stop_token&) {
    if (device_.opened == 10) stop.request_stop();
  };
  EXPECT_EQ(source->read(stop.get_token()), nullptr);
  EXPECT_EQ(source->state(), DeviceState::kLost);
  EXPECT_THAT(source->warnings(), testing::Contains(HasSubstr("16 x 12 instead of 8 x 6")));
  EXPECT_GE(device_.opened, 10);
  EXPECT_LE(source->warnings().size(), 2U) << "once each, however often it was tried";
}

TEST_F(DeviceSourceTest, WhatADeviceHasToSayForDaysDoesNotPileUp) {
  retry_ = Nanoseconds(1);
  device_.acts = {Act::kFrame, Act::kVanish};
  const auto source = open();
  (void)source->read({});
  int attempts = 0;
  std::stop_source stop;
  device_.on_open = [&](const std::stop_token&) {
    if (++attempts == 1000) stop.request_stop();
    throw usage_error(fmt::format("attempt {} was refused", attempts));
  };
  EXPECT_EQ(source->read(stop.get_token()), nullptr);
  EXPECT_EQ(source->warnings().size(), 102U) << "a hundred, how many more, and that it is lost";
  EXPECT_THAT(source->warnings(), testing::Contains(HasSubstr("attempt 1 was refused")));
  EXPECT_THAT(source->warnings(), testing::Contains(HasSubstr("899 more of the like")));
}

TEST_F(DeviceSourceTest, StopEndsAnyWait) {
  device_.acts = {Act::kFrame, Act::kVanish};
  retry_ = std::chrono::hours(1);
  const auto source = open();
  (void)source->read({});
  std::promise<void> tried;
  device_.on_open = [&, first = true](const std::stop_token&) mutable {
    if (std::exchange(first, false)) tried.set_value();
    throw DeviceLost("nothing is there");
  };
  std::stop_source stop;
  const std::jthread later([&] {
    tried.get_future().wait();  // Then it waits an hour.
    stop.request_stop();
  });
  EXPECT_EQ(source->read(stop.get_token()), nullptr);
  EXPECT_EQ(source->read(stop.get_token()), nullptr) << "asked again";
}

// Waits for a stop as a driver does whose library does not answer.
void wait_long(const std::stop_token& stop) {
  std::mutex mutex;
  std::unique_lock lock(mutex);
  std::condition_variable_any never;
  never.wait_for(lock, stop, std::chrono::seconds(30), [] { return false; });
  throw failure("opening was interrupted");
}

TEST_F(DeviceSourceTest, StopEndsAWaitInsideReopening) {
  device_.acts = {Act::kFrame, Act::kVanish};
  const auto source = open();
  ASSERT_TRUE(source->read({}));
  std::stop_source stop;
  std::promise<void> begun;
  const std::jthread other([&] {
    begun.get_future().wait();
    stop.request_stop();
  });
  device_.on_open = [&](const std::stop_token& token) {
    begun.set_value();
    wait_long(token);
  };
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_FALSE(source->read(stop.get_token()));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
  EXPECT_THAT(source->warnings(), ElementsAre(HasSubstr("is not back"))) << "an interruption is nothing to warn of";
}

TEST_F(DeviceSourceTest, StopEndsAWaitInsideTheFirstOpening) {
  std::promise<void> begun;
  const std::jthread other([&] {
    begun.get_future().wait();
    stop_.request_stop();
  });
  device_.on_open = [&](const std::stop_token& token) {
    begun.set_value();
    wait_long(token);
  };
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_TRUE(test::error_of([&] { (void)open(); }));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
}

TEST_F(DeviceSourceTest, ManyLossesAreCounted) {
  for (int k = 0; k < 30; ++k) {
    device_.acts.push_back(Act::kFrame);
    device_.acts.push_back(Act::kVanish);
  }
  const auto source = open();
  Nanoseconds last{0};
  for (int k = 0; k < 31; ++k) {
    const auto frame = source->read({});
    EXPECT_GT(frame->device_time, last);
    last = frame->device_time;
  }
  EXPECT_THAT(source->warnings(), ElementsAre(HasSubstr("was lost 30 times")));
}

TEST_F(DeviceSourceTest, DamagedFramesAreCountedAcrossLosses) {
  const auto source = open();
  device_.acts = {Act::kDamaged, Act::kFrame, Act::kDamaged, Act::kVanish, Act::kDamaged, Act::kFrame};
  ASSERT_TRUE(source->read({}));
  EXPECT_THAT(source->warnings(), testing::Contains(HasSubstr("1 damaged frame was left out")));
  ASSERT_TRUE(source->read({}));
  EXPECT_THAT(source->warnings(), testing::Contains(HasSubstr("3 damaged frames were left out")));
}

TEST_F(DeviceSourceTest, ADeviceThatIsReadLongAfterItWasOpenedIsNotSilent) {
  const auto source = open();
  device_.clock.advance(std::chrono::minutes(1));
  device_.acts = {Act::kSilent, Act::kFrame};
  ASSERT_TRUE(source->read({}));
  EXPECT_THAT(states_, ElementsAre("starting", "running"));
}

TEST_F(DeviceSourceTest, ADeviceThatNobodyListenedToIsNotSilent) {
  const auto source = open();
  ASSERT_TRUE(source->read({}));
  device_.clock.advance(std::chrono::minutes(1));  // Learning the wall, say.
  device_.acts = {Act::kSilent, Act::kFrame};
  ASSERT_TRUE(source->read({}));
  EXPECT_THAT(states_, ElementsAre("starting", "running"));
}

}  // namespace
}  // namespace choreo::devices
