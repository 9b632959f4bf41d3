// SPDX-License-Identifier: Apache-2.0
// Sends pictures through a real video node: vivid's HDMI output leads to its HDMI input.
#pragma once

#include <linux/videodev2.h>
#include <poll.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "devices/fourcc.hpp"
#include "devices/registry.hpp"
#include "devices/v4l2/v4l2_controls.hpp"
#include "devices/v4l2/v4l2_driver.hpp"
#include "devices/vivid.hpp"
#include "pipeline/steady_clock.hpp"

namespace choreo::devices {

inline constexpr int kWidth = 640;
inline constexpr int kHeight = 480;
inline constexpr std::size_t kBytes = 2UL * kWidth * kHeight;

/// vivid's node to send pictures to; empty where it was loaded without one.
inline std::string output_path() {
  for (const auto& path : v4l2::video_nodes()) {
    const v4l2::Node node(path);
    v4l2_capability told{};
    if (node.call(VIDIOC_QUERYCAP, &told) == 0 && (told.device_caps & V4L2_CAP_VIDEO_OUTPUT) != 0) return path;
  }
  return {};
}

inline std::optional<v4l2_dv_timings> timings_640x480(const v4l2::Node& node) {
  v4l2_enum_dv_timings known{};
  for (; node.call(VIDIOC_ENUM_DV_TIMINGS, &known) == 0; ++known.index) {
    const auto& bt = known.timings.bt;
    if (bt.width == kWidth && bt.height == kHeight && bt.interlaced == 0) return known.timings;
  }
  return std::nullopt;
}

/// The socket that takes DV timings, which is HDMI.
template <typename Socket>
int hdmi(const v4l2::Node& node, unsigned long enumerate, std::uint32_t capability) {
  Socket socket{};
  for (; node.call(enumerate, &socket) == 0; ++socket.index) {
    if ((socket.capabilities & capability) != 0) return int(socket.index);
  }
  return -1;
}

/// Streams pictures to an output node, each once, as fast as it takes them.
class Sender {
 public:
  explicit Sender(const v4l2::Node& node) : node_(node) {
    v4l2_requestbuffers request{};
    request.count = 3;
    request.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    request.memory = V4L2_MEMORY_MMAP;
    expect(node_.call(VIDIOC_REQBUFS, &request), "REQBUFS");
    for (std::uint32_t index = 0; index < request.count; ++index) {
      auto buffer = described(index);
      expect(node_.call(VIDIOC_QUERYBUF, &buffer), "QUERYBUF");
      auto* data = ::mmap(nullptr, buffer.length, PROT_READ | PROT_WRITE, MAP_SHARED, node_.fd(), buffer.m.offset);
      expect(data == MAP_FAILED ? errno : 0, "mmap");
      buffers_.emplace_back(static_cast<std::uint8_t*>(data), buffer.length);
    }
  }
  ~Sender() {
    int type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    (void)node_.call(VIDIOC_STREAMOFF, &type);
    for (const auto& buffer : buffers_) ::munmap(buffer.data(), buffer.size());
  }
  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;

  void send(const std::vector<std::uint8_t>& bytes) {
    auto buffer = described(sent_);
    if (sent_ >= buffers_.size()) {
      pollfd ready{node_.fd(), POLLOUT, 0};
      if (::poll(&ready, 1, 1000) <= 0) return;
      expect(node_.call(VIDIOC_DQBUF, &buffer), "DQBUF");
    }
    std::copy(bytes.begin(), bytes.end(), buffers_[buffer.index].begin());
    buffer.bytesused = std::uint32_t(bytes.size());
    buffer.field = V4L2_FIELD_NONE;
    expect(node_.call(VIDIOC_QBUF, &buffer), "QBUF");
    if (++sent_ != buffers_.size()) return;
    int type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    expect(node_.call(VIDIOC_STREAMON, &type), "STREAMON");
  }

 private:
  static v4l2_buffer described(std::size_t index) {
    v4l2_buffer buffer{};
    buffer.index = std::uint32_t(index);
    buffer.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    buffer.memory = V4L2_MEMORY_MMAP;
    return buffer;
  }
  static void expect(int cause, const char* call) { ASSERT_EQ(cause, 0) << call; }

  const v4l2::Node& node_;
  std::vector<std::span<std::uint8_t>> buffers_;
  std::size_t sent_ = 0;
};

/// An input and an output of 640x480 YUYV at 60 pictures a second, joined; skips where there is no such camera.
class Loop : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto input_path = vivid_path();
    if (input_path.empty() || output_path().empty()) GTEST_SKIP() << "there is no vivid camera with an output";
    output_.emplace(output_path());
    int out = hdmi<v4l2_output>(*output_, VIDIOC_ENUMOUTPUT, V4L2_OUT_CAP_DV_TIMINGS);
    ASSERT_EQ(output_->call(VIDIOC_S_OUTPUT, &out), 0);
    auto timings = timings_640x480(*output_);
    ASSERT_TRUE(timings);
    ASSERT_EQ(output_->call(VIDIOC_S_DV_TIMINGS, &*timings), 0);
    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    format.fmt.pix.width = kWidth;
    format.fmt.pix.height = kHeight;
    format.fmt.pix.pixelformat = kYuyv;
    format.fmt.pix.field = V4L2_FIELD_NONE;
    ASSERT_EQ(output_->call(VIDIOC_S_FMT, &format), 0);
    ASSERT_EQ(format.fmt.pix.sizeimage, kBytes);
    int in = 0;
    {
      const v4l2::Node input(input_path);
      in = hdmi<v4l2_input>(input, VIDIOC_ENUMINPUT, V4L2_IN_CAP_DV_TIMINGS);
      ASSERT_EQ(input.call(VIDIOC_S_INPUT, &in), 0);
      ASSERT_EQ(input.call(VIDIOC_S_DV_TIMINGS, &*timings), 0);
      ASSERT_TRUE(v4l2::set_controls(input, {{"loop_video", "1"}, {"osd_text_mode", "2"}}).empty());
    }
    source_ = "v4l2://" + input_path + "?size=640x480&format=YUYV&input=" + std::to_string(in);
    registry_.add(v4l2_driver(clock_));
  }

  void TearDown() override {
    if (source_.empty()) return;
    int webcam = 0;
    ASSERT_EQ(v4l2::Node(vivid_path()).call(VIDIOC_S_INPUT, &webcam), 0);
  }

  /// Sends the pictures round and round until it is destroyed.
  std::jthread sending(const std::vector<std::vector<std::uint8_t>>& pictures) {
    return std::jthread([&pictures, &node = *output_](const std::stop_token& stop) {
      Sender to(node);
      for (std::size_t k = 0; !stop.stop_requested(); ++k) to.send(pictures[k % pictures.size()]);
    });
  }

  pipeline::SteadyClock clock_;
  Registry registry_;
  std::optional<v4l2::Node> output_;
  std::string source_;
};

}  // namespace choreo::devices
