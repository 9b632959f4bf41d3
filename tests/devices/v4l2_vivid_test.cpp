// SPDX-License-Identifier: Apache-2.0
// The V4L2 driver on the kernel's own virtual camera, vivid, and the faults that it can be told to have. Runs inside
// the virtual machine of script/v4l2-vm. Without vivid these tests are skipped and say so, while those of the
// conformance suite fail: a machine whose camera did not come up does not pass.
#include <linux/videodev2.h>
#include <sys/fsuid.h>
#include <sys/stat.h>

#include <chrono>
#include <mutex>
#include <thread>

#include <gmock/gmock.h>
#include <opencv2/core.hpp>

#include "core/error.hpp"
#include "devices/v4l2/v4l2_controls.hpp"
#include "devices/v4l2/v4l2_driver.hpp"
#include "devices/v4l2/v4l2_node.hpp"
#include "devices/v4l2/v4l2_session.hpp"
#include "devices/vivid.hpp"
#include "pipeline/steady_clock.hpp"
#include "support/frames.hpp"

namespace choreo::devices {
namespace {

using namespace std::chrono_literals;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using v4l2::Node;

// A session whose numbers are looked at before anybody makes something of them.
class Watched final : public DeviceSession {
 public:
  Watched(std::unique_ptr<DeviceSession> session, bool& has_wrapped)
      : session_(std::move(session)), has_wrapped_(has_wrapped) {}
  [[nodiscard]] const SourceInfo& info() const override { return session_->info(); }
  [[nodiscard]] bool stamps_with_host_clock() const override { return session_->stamps_with_host_clock(); }
  [[nodiscard]] std::optional<DeviceFrame> wait(Nanoseconds patience) override {
    auto frame = session_->wait(patience);
    if (frame && frame->counter < 1000) has_wrapped_ = true;
    return frame;
  }

 private:
  std::unique_ptr<DeviceSession> session_;
  bool& has_wrapped_;
};

class Vivid : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ = vivid_path();
    if (path_.empty()) GTEST_SKIP() << "there is no vivid camera; script/v4l2-vm runs this where there is one";
    registry_.add(v4l2_driver(clock_));
    tell({{"percentage_of_dropped_buffers", "0"}, {"wrap_sequence_number", "0"}, {"wrap_timestamp", "0"}});
  }

  // What vivid is told, by a file descriptor of its own.
  void tell(const std::map<std::string, std::string>& controls) const {
    const Node node(path_);
    (void)v4l2::set_controls(node, controls);
  }
  [[nodiscard]] std::int64_t asked(const std::string& name) const {
    const Node node(path_);
    for (const auto& control : v4l2::controls_of(node)) {
      if (control.name == name) return control.value;
    }
    ADD_FAILURE() << "vivid has no control " << name;
    return -1;
  }

  std::unique_ptr<Source> open(const std::string& settings = "size=640x360") {
    OpenOptions options;
    options.on_event = [this](const DeviceEvent& event) { events_.push_back(event); };
    return registry_.open("v4l2://" + path_ + "?" + settings, options);
  }

  // Reads, some seconds at most, until something has happened that has not been asked for before.
  bool read_until(Source& source, DeviceState state) {
    const auto limit = std::chrono::steady_clock::now() + 20s;
    while (std::chrono::steady_clock::now() < limit) {
      while (asked_for_ < events_.size()) {
        if (events_[asked_for_++].state == state) return true;
      }
      std::stop_source stop;
      const std::jthread patience([&](const std::stop_token& over) {
        std::mutex mutex;
        std::unique_lock lock(mutex);
        std::condition_variable_any never;
        if (!never.wait_for(lock, over, 300ms, [] { return false; }) && !over.stop_requested()) stop.request_stop();
      });
      (void)source.read(stop.get_token());
    }
    return false;
  }
  // Reads for so long. @return whether a frame came.
  static bool read_for(Source& source, std::chrono::milliseconds time) {
    std::stop_source stop;
    const std::jthread patience([&] {
      std::this_thread::sleep_for(time);
      stop.request_stop();
    });
    return source.read(stop.get_token()) != nullptr;
  }
  void read_some(Source& source, int count = 3) {
    for (int k = 0; k < count; ++k) ASSERT_TRUE(source.read({}));
  }
  void expect_lost_and_found(Source& source) {
    EXPECT_TRUE(read_until(source, DeviceState::kLost)) << "not seen to be lost";
    EXPECT_TRUE(read_until(source, DeviceState::kRunning)) << "not taken up again";
    read_some(source);
  }

  pipeline::SteadyClock clock_;
  Registry registry_;
  std::string path_;
  std::vector<DeviceEvent> events_;
  std::size_t asked_for_ = 0;
};

TEST_F(Vivid, GivesFramesInOrderAtTheKernelsTimes) {
  const auto source = open();
  EXPECT_EQ(source->info().size, cv::Size(640, 360));
  EXPECT_NEAR(source->info().nominal_fps, 30, 0.1);
  FramePtr last;
  Nanoseconds oldest{0};
  for (int k = 0; k < 60; ++k) {
    const auto frame = source->read({});
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->bgr.size(), cv::Size(640, 360));
    EXPECT_EQ(frame->bgr.type(), CV_8UC3);
    const auto age = clock_.now() - frame->device_time;
    EXPECT_GE(age, 0ns);
    oldest = std::max(oldest, age);
    if (last) {
      EXPECT_GT(frame->sequence, last->sequence);
      EXPECT_GT(frame->device_time, last->device_time);
    }
    last = frame;
  }
  std::printf("vivid 640x360: age of a frame when the pipeline gets it: at most %.1f ms over 60 frames\n",
              1e3 * to_seconds(oldest));
}

TEST_F(Vivid, EveryFormatShowsTheSamePicture) {
  tell({{"test_pattern", "0"}, {"osd_text_mode", "2"}, {"horizontal_movement", "3"}});
  cv::Mat expected;
  for (const auto* format : {"BGR3", "RGB3", "YUYV", "UYVY", "YVYU", "NV12"}) {
    const auto source = open(std::string("size=640x360&format=") + format);
    read_some(*source, 1);
    const auto picture = source->read({})->bgr;
    if (expected.empty()) {
      expected = picture;
      EXPECT_GT(cv::norm(picture, cv::NORM_INF), 150) << "colour bars are bright";
    }
    const double off = cv::norm(picture, expected, cv::NORM_L1) / double(3 * picture.total());
    EXPECT_LT(off, 6) << format;
  }
  EXPECT_TRUE(open("size=640x360&format=GREY")->read({}));
}

TEST_F(Vivid, ControlsAreSetAndReadBack) {
  const auto source = open("size=640x360&brightness=77&contrast=99");
  EXPECT_EQ(asked("brightness"), 77);
  EXPECT_EQ(asked("contrast"), 99);
  EXPECT_TRUE(source->read({}));
}

TEST_F(Vivid, RefusesControlsAndModesThatItHasNot) {
  const auto refused = [&](const std::string& settings) {
    const auto error = test::error_of([&] { (void)open(settings); });
    return error && error->fault() == Fault::kUsage ? std::string(error->what()) + " / " + error->hint() : "opened";
  };
  EXPECT_THAT(refused("brightnes=1"), HasSubstr("did you mean \"brightness\""));
  EXPECT_THAT(refused("brightness=100000"), HasSubstr("from 0 to 255"));
  EXPECT_THAT(refused("brightness=bright"), HasSubstr("from 0 to 255"));
  EXPECT_THAT(refused("size=641x360"), HasSubstr("no such mode"));
  EXPECT_THAT(refused("input=17"), HasSubstr("0 (Webcam"));
}

TEST_F(Vivid, DroppedBuffersAreGapsInTheNumbers) {
  tell({{"percentage_of_dropped_buffers", "30"}});
  const auto source = open();
  const auto first = source->read({})->sequence;
  std::uint64_t last = first;
  for (int k = 0; k < 40; ++k) last = source->read({})->sequence;
  EXPECT_GT(last - first, 44U);
  EXPECT_THAT(events_.back().state, DeviceState::kRunning);
}

TEST_F(Vivid, WhereEveryBufferIsDroppedItIsLostWithinASecondAndComesBack) {
  const auto source = open();
  read_some(*source);
  tell({{"percentage_of_dropped_buffers", "100"}});
  const auto since = clock_.now();
  ASSERT_TRUE(read_until(*source, DeviceState::kLost));
  const auto& lost = events_[asked_for_ - 1];
  EXPECT_LT(lost.at - since, 1s);
  EXPECT_THAT(lost.why, HasSubstr("no frame for"));
  tell({{"percentage_of_dropped_buffers", "0"}});
  EXPECT_TRUE(read_until(*source, DeviceState::kRunning));
}

TEST_F(Vivid, DamagedFramesAreLeftOut) {
  const auto source = open();
  read_some(*source);
  tell({{"inject_v4l2_buf_flag_error", "1"}});
  read_some(*source, 10);
  EXPECT_THAT(source->warnings(), Contains(HasSubstr("1 damaged frame was left out")));
  EXPECT_EQ(events_.back().state, DeviceState::kRunning);
}

TEST_F(Vivid, AStreamThatBreaksIsTakenUpAgain) {
  const auto source = open();
  read_some(*source);
  tell({{"inject_fatal_streaming_error", "1"}});
  expect_lost_and_found(*source);
}

TEST_F(Vivid, ABufferThatIsNotTakenBackIsALossThatMends) {
  const auto source = open();
  read_some(*source);
  tell({{"inject_vidioc_qbuf_error", "1"}});
  expect_lost_and_found(*source);
}

TEST_F(Vivid, AStartThatFailsIsRefusedAndTheNextOneWorks) {
  for (const auto* fault : {"inject_vidioc_reqbufs_error", "inject_vidioc_streamon_error"}) {
    tell({{fault, "1"}});
    const auto error = test::error_of([&] { (void)open(); });
    EXPECT_TRUE(error) << fault;
    EXPECT_EQ(events_.back().state, DeviceState::kFailed) << fault;
    EXPECT_TRUE(open()->read({})) << fault;
  }
}

TEST_F(Vivid, AnAttemptToTakeItUpAgainThatFailsIsFollowedByAnother) {
  for (const auto* fault : {"inject_vidioc_reqbufs_error", "inject_vidioc_streamon_error"}) {
    const auto source = open();
    read_some(*source);
    tell({{fault, "1"}});
    tell({{"inject_fatal_streaming_error", "1"}});
    ASSERT_TRUE(read_until(*source, DeviceState::kLost)) << fault;
    const auto lost = events_[asked_for_ - 1].at;
    ASSERT_TRUE(read_until(*source, DeviceState::kRunning)) << fault;
    EXPECT_GE(events_[asked_for_ - 1].at - lost, 250ms) << fault << ": there was no failed attempt";
    read_some(*source);
    EXPECT_THAT(source->warnings(), ElementsAre(HasSubstr("was lost 1 time and taken up again"))) << fault;
  }
}

// The kernel makes the node first; udev gives the permissions to it a little later.
TEST_F(Vivid, ANodeThatMayNotBeOpenedYetIsWaitedFor) {
  const auto source = open();
  read_some(*source);
  tell({{"inject_fatal_streaming_error", "1"}});
  ASSERT_EQ(::chmod(path_.c_str(), 0600), 0);
  ::setfsuid(65534);  // Of this thread, which reads.
  const bool lost = read_until(*source, DeviceState::kLost);
  const auto count = events_.size();
  const bool back = read_for(*source, 1s);
  ::setfsuid(0);
  EXPECT_TRUE(lost);
  EXPECT_FALSE(back);
  EXPECT_EQ(events_.size(), count);
  EXPECT_TRUE(read_until(*source, DeviceState::kRunning));
  EXPECT_THAT(source->warnings(), ElementsAre(HasSubstr("was lost 1 time")));
}

TEST_F(Vivid, ARateThatItHasNotIsTold) {
  const auto source = open("size=640x360&fps=999&brightness=77");
  read_some(*source, 1);
  EXPECT_THAT(source->warnings(), Contains(HasSubstr("999 were asked for")));
}

TEST_F(Vivid, TheControlsItTellsOfCanBeGivenBack) {
  const auto controls = open("size=640x360&brightness=77")->info().controls;
  EXPECT_THAT(controls, HasSubstr("brightness=77"));
  EXPECT_THAT(controls, Not(HasSubstr("disconnect"))) << "a button has no value";
}

TEST_F(Vivid, ADeviceThatIsUnpluggedIsTakenUpAgainWithItsSettings) {
  const auto source = open("size=640x360&brightness=77");
  read_some(*source);
  tell({{"brightness", "11"}});
  tell({{"disconnect", "1"}});
  expect_lost_and_found(*source);
  EXPECT_EQ(asked("brightness"), 77);
}

TEST_F(Vivid, NumbersAndTimesThatWrapGoOn) {
  // Where the numbers start is settled when the stream does: 128 frames before they wrap.
  tell({{"wrap_sequence_number", "1"}, {"wrap_timestamp", "1"}});
  v4l2::Wish wish;
  wish.path = path_;
  wish.size = cv::Size(320, 180);
  wish.fps = 60;
  bool has_wrapped = false;  // What the kernel says.
  const auto open_session = [&](const std::stop_token&) {
    auto session = std::make_unique<v4l2::Session>(wish, clock_);
    std::optional<DeviceFrame> first;
    for (int k = 0; k < 100 && !first; ++k) first = session->wait(100ms);
    EXPECT_TRUE(first && first->counter > 0xFFFFFF00U) << "vivid did not start before the wrap";
    return std::make_unique<Watched>(std::move(session), has_wrapped);
  };
  DeviceSource source("vivid", open_session, clock_, {});
  auto last = source.read({});
  const auto first = last->sequence;
  const auto go_on = [&](std::uint64_t until) {
    while (last->sequence < first + until) {
      const auto frame = source.read({});
      ASSERT_TRUE(frame);
      ASSERT_GT(frame->sequence, last->sequence);
      EXPECT_LT(frame->sequence, last->sequence + 100);
      EXPECT_GT(frame->device_time, last->device_time);
      EXPECT_LT(frame->device_time, last->device_time + 5s);
      EXPECT_LE(frame->device_time, clock_.now());
      last = frame;
    }
  };
  go_on(200);
  EXPECT_TRUE(has_wrapped);
  tell({{"wrap_timestamp", "0"}});  // A step back, by decades.
  go_on(260);
  EXPECT_LT(clock_.now() - last->device_time, 1s);
  EXPECT_EQ(source.state(), DeviceState::kRunning);
  tell({{"wrap_sequence_number", "0"}});
}

TEST_F(Vivid, WhoeverReadsLateGetsTheNewestFrame) {
  const auto source = open();
  read_some(*source);
  for (int k = 0; k < 5; ++k) {
    std::this_thread::sleep_for(400ms);  // Twelve frames.
    const auto frame = source->read({});
    EXPECT_LT(clock_.now() - frame->device_time, 150ms);
  }
}

TEST_F(Vivid, StartsAndStopsAsOftenAsAnybodyLikes) {
  for (int k = 0; k < 10; ++k) {
    const auto source = open();
    if (k % 2 == 0) {
      EXPECT_TRUE(source->read({}));
    }
  }
}

}  // namespace
}  // namespace choreo::devices
