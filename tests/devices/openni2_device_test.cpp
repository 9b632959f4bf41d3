// SPDX-License-Identifier: Apache-2.0
// A camera behind OpenNI2: what it gives, and what becomes of it when it, the library or the helper fails.
#include <sys/stat.h>

#include <csignal>
#include <future>
#include <thread>

#include "devices/device_source.hpp"
#include "devices/openni2/openni2_session.hpp"
#include "devices/openni2_fixture.hpp"

namespace choreo::test {
namespace {

using devices::DeviceState;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

class OpenNi2DeviceTest : public OpenNi2Test {
 protected:
  // Opens it, noting what becomes of it; "lost" tells the camera `then`.
  std::unique_ptr<devices::Source> watch(const std::string& source, const std::string& then = {}) {
    devices::OpenOptions options;
    options.on_event = [this, then](const devices::DeviceEvent& event) {
      events_.push_back(event);
      if (event.state == DeviceState::kLost) tell(then);
    };
    return open(source, options);
  }
  // Reads until it was lost and is back.
  devices::FramePtr read_past_loss(devices::Source& source) {
    const auto lost = [&] {
      return std::any_of(events_.begin(), events_.end(),
                         [](const auto& event) { return event.state == DeviceState::kLost; });
    };
    for (int k = 0; k < 300; ++k) {
      auto frame = source.read({});
      if (lost()) return frame;
      last_before_ = frame;
    }
    return nullptr;
  }
  // The first loss.
  devices::DeviceEvent loss() const {
    for (const auto& event : events_) {
      if (event.state == DeviceState::kLost) return event;
    }
    ADD_FAILURE() << "it was not lost";
    return {};
  }
  std::string why_lost() const { return loss().why; }
  void script(const std::string& text) {
    const auto path = folder_ / "helper";
    write_bytes(path, "#!/bin/sh\n" + text + "\n");
    ::chmod(path.c_str(), 0700);
    ::setenv("CHOREO_OPENNI2_HELPER", path.c_str(), 1);
  }

  std::vector<devices::DeviceEvent> events_;
  devices::FramePtr last_before_;
};

TEST_F(OpenNi2DeviceTest, LiveFramesAreExactAndPaired) {
  const auto source = open("openni2://");
  EXPECT_EQ(source->info().size, cv::Size(kOniWidth, kOniHeight));
  EXPECT_FALSE(source->info().repeatable);
  devices::FramePtr last;
  int paired = 0;
  for (int k = 0; k < 20; ++k) {
    const auto frame = source->read({});
    ASSERT_TRUE(frame);
    const int number = picture_number(frame->bgr);
    ASSERT_GE(number, 0);
    EXPECT_TRUE(frame->depth.empty() || is_depth_of(frame->depth, number));
    paired += frame->depth.empty() ? 0 : 1;
    if (last) {
      EXPECT_EQ(frame->sequence - last->sequence, std::uint64_t(number - picture_number(last->bgr)));
      EXPECT_GT(frame->device_time, last->device_time);
    }
    last = frame;
  }
  EXPECT_GE(paired, 10);
  EXPECT_THAT(source->warnings(), IsEmpty());
}

TEST_F(OpenNi2DeviceTest, TheListNamesItByItsSerialNumber) {
  const auto list = registry_.drivers()[0].list();
  EXPECT_EQ(list.trouble, "");
  ASSERT_EQ(list.devices.size(), 1U);
  const auto& device = list.devices[0];
  EXPECT_EQ(device.source, "openni2://T-0042");
  EXPECT_EQ(device.name, "Choreo Test Camera");
  EXPECT_EQ(device.trouble, "");
  ASSERT_EQ(device.modes.size(), 2U);
  EXPECT_EQ(device.modes[0].format, "colour RGB3");
  EXPECT_EQ(device.modes[0].size, cv::Size(kOniWidth, kOniHeight));
  EXPECT_EQ(device.modes[0].fps, std::vector<double>{kOniFps});
  EXPECT_EQ(device.modes[1].format, "depth Z16");
  EXPECT_TRUE(open(device.source)->read({}));
}

TEST_F(OpenNi2DeviceTest, OneThatIsNotThereIsRefused) {
  const auto other = error_of([&] { (void)open("openni2://T-0043"); });
  ASSERT_TRUE(other);
  EXPECT_EQ(other->fault(), Fault::kUsage);
  EXPECT_THAT(other->what(), HasSubstr("no device \"T-0043\", but choreo/"));
  tell("gone");
  const auto none = error_of([&] { (void)open("openni2://"); });
  ASSERT_TRUE(none);
  EXPECT_EQ(none->fault(), Fault::kUsage);
  EXPECT_THAT(none->what(), HasSubstr("finds no device"));
  EXPECT_THAT(registry_.drivers()[0].list().devices, IsEmpty());
}

TEST_F(OpenNi2DeviceTest, OneThatIsUnpluggedIsFoundAgainAtAnotherPort) {
  for (const std::string way : {"", "plain"}) {
    tell(way);  // With a serial number, and without one.
    events_.clear();
    const auto source = watch("openni2://", way);
    last_before_ = source->read({});
    tell("gone");
    const auto frame = read_past_loss(*source);
    ASSERT_TRUE(frame);
    EXPECT_EQ(why_lost(), "the device is gone");
    EXPECT_GT(frame->sequence, last_before_->sequence);
    EXPECT_GT(frame->device_time, last_before_->device_time);
    EXPECT_EQ(events_.back().state, DeviceState::kRunning);
  }
}

TEST_F(OpenNi2DeviceTest, OneThatFallsSilentIsLostWithinASecond) {
  const auto source = watch("openni2://");
  (void)source->read({});
  const auto since = clock_.now();
  tell("silent");
  ASSERT_TRUE(read_past_loss(*source));
  EXPECT_THAT(why_lost(), HasSubstr("no frame for 0."));
  EXPECT_LT(loss().at - since, std::chrono::seconds(1));
}

TEST_F(OpenNi2DeviceTest, AfterAPauseTheNextFrameIsYoung) {
  const auto source = open("openni2://");
  for (int k = 0; k < 5; ++k) ASSERT_TRUE(source->read({}));
  std::this_thread::sleep_for(std::chrono::seconds(2));  // Long enough to fill every place there is.
  for (int k = 0; k < 3; ++k) {
    const auto frame = source->read({});
    ASSERT_TRUE(frame);
    EXPECT_LT(clock_.now() - frame->device_time, std::chrono::milliseconds(300));
    EXPECT_FALSE(frame->depth.empty());
  }
  EXPECT_THAT(source->warnings(), IsEmpty()) << "nor was it lost";
}

TEST_F(OpenNi2DeviceTest, AShortPauseLosesNothingWhereEveryFrameIsWanted) {
  devices::OpenOptions options;
  options.every_frame = true;
  const auto source = open("openni2://", options);
  devices::FramePtr last;
  for (int k = 0; k < 20; ++k) {
    const auto frame = source->read({});
    ASSERT_TRUE(frame);
    // What waited while the first was read may have been too much.
    if (k > 5) {
      EXPECT_EQ((picture_number(frame->bgr) + 256 - picture_number(last->bgr)) % 256, 1);
      EXPECT_EQ(frame->sequence, last->sequence + 1);
    }
    if (k == 10) std::this_thread::sleep_for(std::chrono::milliseconds(130));
    last = frame;
  }
}

TEST_F(OpenNi2DeviceTest, OneStreamThatFallsSilentIsALossThoughTheOtherGoesOn) {
  for (const auto& [word, told] : {std::pair{"nodepth", "the depth stream is silent: no picture for 0."},
                                   std::pair{"nocolour", "the colour stream is silent: no picture for 0."}}) {
    tell("");
    events_.clear();
    const auto source = watch("openni2://");
    ASSERT_TRUE(source->read({}));
    tell(word);
    const auto frame = read_past_loss(*source);
    ASSERT_TRUE(frame) << word;
    EXPECT_THAT(why_lost(), StartsWith(told));
    EXPECT_FALSE(frame->depth.empty());
    EXPECT_EQ(events_.back().state, DeviceState::kRunning);
  }
}

TEST_F(OpenNi2DeviceTest, ItDoesNotRunAgainBeforeBothStreamsDo) {
  const auto source = watch("openni2://", "nodepth");
  ASSERT_TRUE(source->read({}));
  tell("nodepth");
  std::stop_source stop;
  const std::jthread later([&] {
    std::this_thread::sleep_for(std::chrono::seconds(2));
    stop.request_stop();
  });
  while (source->read(stop.get_token())) continue;
  EXPECT_EQ(events_.back().state, DeviceState::kLost) << "colour alone is not what was asked for";
  tell("");
  const auto frame = source->read({});
  ASSERT_TRUE(frame);
  EXPECT_FALSE(frame->depth.empty());
}

TEST_F(OpenNi2DeviceTest, ACrashOfTheLibraryIsALossAndNoMore) {
  const auto source = watch("openni2://");
  (void)source->read({});
  tell("crash");
  ASSERT_TRUE(read_past_loss(*source));
  EXPECT_THAT(why_lost(), HasSubstr("OpenNI2"));
}

TEST_F(OpenNi2DeviceTest, AHelperThatIsStoppedIsReplaced) {
  devices::openni2::Request request;
  request.action = devices::openni2::Action::kDevice;
  pid_t first = 0;
  const auto open_session = [&](const std::stop_token& stop) -> std::unique_ptr<devices::DeviceSession> {
    auto session = std::make_unique<devices::openni2::Session>(request, "openni2://", false, clock_,
                                                               std::chrono::seconds(5), stop);
    if (first == 0) first = session->helper();
    return session;
  };
  devices::DeviceOptions options;
  options.on_event = [this](const devices::DeviceEvent& event) { events_.push_back(event); };
  devices::DeviceSource source("openni2://", open_session, clock_, options);
  ASSERT_TRUE(source.read({}));
  const auto since = clock_.now();
  ::kill(first, SIGSTOP);
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(source.read({}));
  EXPECT_EQ(::kill(first, 0), -1) << "the first one is still there";
  EXPECT_LT(loss().at - since, std::chrono::seconds(1)) << "told before it is closed, which takes longer";
}

TEST_F(OpenNi2DeviceTest, TheHelperEndsWithTheSession) {
  devices::openni2::Request request;
  request.action = devices::openni2::Action::kDevice;
  std::optional<devices::openni2::Session> session;
  session.emplace(request, "openni2://", false, clock_, std::chrono::seconds(5), std::stop_token());
  const auto helper = session->helper();
  EXPECT_EQ(::kill(helper, 0), 0);
  session.reset();
  EXPECT_EQ(::kill(helper, 0), -1);
}

TEST_F(OpenNi2DeviceTest, WhatItHasNotIsRefusedOrSaid) {
  const auto size = error_of([&] { (void)open("openni2://?size=320x240"); });
  ASSERT_TRUE(size);
  EXPECT_EQ(size->fault(), Fault::kUsage);
  EXPECT_THAT(size->what(), HasSubstr("no such colour mode"));
  EXPECT_THAT(size->hint(), HasSubstr("64x48 at 30"));
  for (const auto* bad : {"size=320", "size=0x10", "fps=-1", "registration=maybe", "video=x", "colour=1"}) {
    const auto error = error_of([&] { (void)open(std::string("openni2://?") + bad); });
    ASSERT_TRUE(error) << bad;
    EXPECT_EQ(error->fault(), Fault::kUsage) << bad;
  }
  const auto fast = open("openni2://?fps=60&size=64x48");
  (void)fast->read({});
  EXPECT_THAT(fast->warnings(), Contains(HasSubstr("60 were asked for")));
  tell("plain");
  const auto plain = open("openni2://");
  (void)plain->read({});
  EXPECT_THAT(plain->warnings(), Contains(HasSubstr("cannot bring depth onto colour")));
  const auto wanted_not = open("openni2://?registration=off");
  (void)wanted_not->read({});
  EXPECT_THAT(wanted_not->warnings(), IsEmpty());
}

TEST_F(OpenNi2DeviceTest, OfDepthAloneThePictureIsGrey) {
  tell("depth");
  const auto source = open("openni2://");
  const auto frame = source->read({});
  // 600 mm and more, at the left; 1260 mm and more at the right: the nearer the whiter.
  const auto left = frame->bgr.at<cv::Vec3b>(0, 1);
  const auto right = frame->bgr.at<cv::Vec3b>(0, 62);
  EXPECT_TRUE(frame->depth.at<std::uint16_t>(0, 1) == 0 || left[0] > right[0] || right[0] == 0);
  EXPECT_EQ(left[0], left[1]);
  EXPECT_EQ(left[0], left[2]);
  const auto colour = error_of([&] { (void)open("openni2://?video=rgb"); });
  ASSERT_TRUE(colour);
  EXPECT_THAT(colour->what(), HasSubstr("there is no colour"));
}

TEST_F(OpenNi2DeviceTest, ColourAloneHasNoDepth) {
  tell("colour");
  const auto frame = open("openni2://")->read({});
  EXPECT_GE(picture_number(frame->bgr), 0);
  EXPECT_TRUE(frame->depth.empty());
}

TEST_F(OpenNi2DeviceTest, AMissingFolderOfDriversIsExplained) {
  std::filesystem::remove_all(folder_ / "OpenNI2");
  const auto error = error_of([&] { (void)open("openni2://"); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->fault(), Fault::kUsage);
  EXPECT_THAT(error->what(), HasSubstr("finds no drivers"));
  EXPECT_THAT(error->hint(), HasSubstr("OpenNI2/Drivers"));
  const auto list = registry_.drivers()[0].list();
  EXPECT_THAT(list.trouble, HasSubstr("finds no drivers"));
  EXPECT_THAT(list.remedy, HasSubstr("OpenNI2/Drivers"));
}

TEST_F(OpenNi2DeviceTest, WithoutItsHelperItSaysSo) {
  ::setenv("CHOREO_OPENNI2_HELPER", "/nowhere/helper", 1);
  const auto error = error_of([&] { (void)open("openni2://"); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->fault(), Fault::kUsage);
  EXPECT_THAT(error->what(), HasSubstr("\"/nowhere/helper\" is no program"));
  EXPECT_THAT(registry_.drivers()[0].list().trouble, HasSubstr("/nowhere/helper"));
}

TEST_F(OpenNi2DeviceTest, AHelperThatSaysNothingOrNonsenseIsRefused) {
  devices::Registry quick;
  quick.add(devices::openni2_driver(clock_, std::chrono::milliseconds(300)));
  const auto told = [&](const std::string& text) {
    script(text);
    const auto error = error_of([&] { (void)quick.open("openni2://"); });
    EXPECT_TRUE(error && error->fault() == Fault::kUsage) << text;
    return error ? std::string(error->what()) : std::string();
  };
  EXPECT_THAT(told("exit 0"), HasSubstr("ended with status 0"));
  EXPECT_THAT(told("exit 127"), HasSubstr("libopenni2-0"));
  EXPECT_THAT(told("kill -SEGV $$"), HasSubstr("crashed (Segmentation fault)"));
  EXPECT_THAT(told("exec sleep 100"), HasSubstr("hangs"));
  EXPECT_THAT(told("echo nonsense >&0; exec sleep 100"), HasSubstr("went mad"));
  EXPECT_THAT(told("head -c 100000 /dev/zero >&0; exec sleep 100"), HasSubstr("went mad"));
}

TEST_F(OpenNi2DeviceTest, StopEndsTheWaitForOneThatIsAway) {
  std::promise<void> lost;
  devices::OpenOptions options;
  options.on_event = [&](const devices::DeviceEvent& event) {
    events_.push_back(event);
    if (event.state == DeviceState::kLost) lost.set_value();
  };
  const auto source = open("openni2://", options);
  (void)source->read({});
  tell("gone");
  std::stop_source stop;
  const std::jthread later([&] {
    lost.get_future().wait();
    stop.request_stop();
  });
  while (source->read(stop.get_token())) {
  }
  EXPECT_EQ(events_.back().state, DeviceState::kLost);
}

}  // namespace
}  // namespace choreo::test
