// SPDX-License-Identifier: Apache-2.0
// Cameras on the network as they should be: pictures, order, times, the newest first; recordings whole.
#include <atomic>
#include <cstdio>

#include "devices/fourcc.hpp"
#include "devices/media/raw_converter.hpp"
#include "devices/network_fixture.hpp"
#include "outputs/video_writer.hpp"
#include "support/eventually.hpp"
#include "support/make_video.hpp"
#include "support/temp_folder.hpp"

namespace choreo::devices {
namespace {

using test::Caller;
using test::LoopbackServer;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class NetworkCamera : public NetworkTest {};

TEST_F(NetworkCamera, GivesThePicturesAsTheyWereSentInTheirOrder) {
  std::vector<test::Bytes> sent;
  for (int k = 0; k < 200; ++k) sent.push_back(test::jpeg_of(test::numbered_picture(k)));
  const LoopbackServer server([&](Caller& caller) {
    (void)caller.request();
    (void)test::send_multipart_head(caller);
    for (const auto& jpeg : sent) {
      if (!test::send_part(caller, jpeg) || !caller.wait(20ms)) return;
    }
    caller.wait_for_the_end();
  });
  const auto source = open(server.address() + "/video", true);
  EXPECT_EQ(source->info().size, cv::Size(160, 96));
  EXPECT_EQ(source->info().nominal_fps, 0) << "nobody said";
  EXPECT_FALSE(source->info().repeatable);
  RawConverter converter;
  FramePtr last;
  int last_number = -1;
  for (int k = 0; k < 50; ++k) {
    const auto frame = read(*source);
    ASSERT_TRUE(frame);
    const int number = test::number_of(frame->bgr);
    ASSERT_GT(number, last_number);
    ASSERT_TRUE(frame->raw_colour);
    EXPECT_EQ(frame->raw_colour->fourcc, kMjpg);
    EXPECT_EQ(frame->raw_colour->bytes, sent.at(std::size_t(number)));
    EXPECT_TRUE(test::same_pixels(frame->bgr, converter.to_bgr(*frame->raw_colour)));
    if (last) {
      EXPECT_EQ(frame->sequence - last->sequence, std::uint64_t(number - last_number)) << "a gap is a lost picture";
      EXPECT_GT(frame->device_time, last->device_time);
    }
    last = frame;
    last_number = number;
  }
  EXPECT_THAT(states(), ElementsAre("starting", "running"));
  EXPECT_THAT(source->warnings(), IsEmpty());
}

TEST_F(NetworkCamera, WhoeverReadsLateGetsTheNewestPicture) {
  std::mutex mutex;
  std::vector<Nanoseconds> sent;
  const LoopbackServer server([&](Caller& caller) {
    (void)caller.request();
    bool there = test::send_multipart_head(caller);
    for (int k = 0; there; ++k) {
      {
        const std::scoped_lock lock(mutex);
        sent.push_back(clock_.now());
      }
      there = test::send_part(caller, test::jpeg_of(test::numbered_picture(k, {640, 480}))) && caller.wait(16ms);
    }
  });
  const auto source = open(server.address());
  const auto measure = [&](int count, std::chrono::milliseconds pause) {
    Nanoseconds oldest{0};
    std::size_t least_behind = 1000;  // Pictures sent since: in a queue all are behind, a busy machine delays some.
    Nanoseconds sum{0};
    for (int k = 0; k < count; ++k) {
      std::this_thread::sleep_for(pause);  // The reader is slow, by the real clock.
      const auto frame = read(*source);
      const auto now = clock_.now();
      if (!frame) return least_behind;
      const std::scoped_lock lock(mutex);
      const auto number = std::size_t(test::number_of(frame->bgr));
      const auto age = now - sent.at(number);
      EXPECT_LE(frame->device_time, now);
      oldest = std::max(oldest, age);
      if (k >= count / 2) least_behind = std::min(least_behind, sent.size() - 1 - number);
      sum += age;
    }
    std::printf(
        "multipart JPEG 640x480 at 60 a second, a read every %d ms: age since it was sent: mean %.1f, at most "
        "%.1f ms over %d frames\n",
        int(pause.count()), 1e3 * to_seconds(sum) / count, 1e3 * to_seconds(oldest), count);
    return least_behind;
  };
  EXPECT_LE(measure(8, 300ms), 4U) << "in the queue for whoever wants every frame it would be seven";
  EXPECT_LE(measure(60, 0ms), 4U);
}

TEST_F(NetworkCamera, AShortPauseLosesNothingWhereEveryFrameIsWanted) {
  std::atomic<int> sent{0};
  const LoopbackServer server([&](Caller& caller) {
    (void)caller.request();
    bool there = test::send_multipart_head(caller);
    for (int k = 0; there; ++k) {
      there = test::send_part(caller, test::jpeg_of(test::numbered_picture(k)));
      sent = k + 1;
      there = there && caller.wait(40ms);
    }
  });
  OpenOptions options;
  options.every_frame = true;
  const auto source = registry_.open(server.address(), options);
  FramePtr last;
  for (int k = 0; k < 24; ++k) {
    const auto frame = read(*source);
    ASSERT_TRUE(frame);
    // What waited while the stream was looked at may have been too much.
    if (k > 12) {
      EXPECT_EQ(test::number_of(frame->bgr), test::number_of(last->bgr) + 1);
      EXPECT_EQ(frame->sequence, last->sequence + 1);
    }
    if (k == 14) {
      const int number = test::number_of(frame->bgr);
      ASSERT_TRUE(test::eventually([&] { return sent > number + 3; })) << "three more pictures are waiting";
    }
    last = frame;
  }
}

TEST_F(NetworkCamera, PicturesWithoutALengthAreReadAsWell) {
  const LoopbackServer server([](Caller& caller) {
    (void)caller.request();
    bool there = test::send_multipart_head(caller);
    for (int k = 0; there; ++k) {
      there = caller.send("--next\r\nContent-Type: image/jpeg\r\n\r\n") &&
              caller.send(test::jpeg_of(test::numbered_picture(k))) && caller.send("\r\n") && caller.wait(20ms);
    }
  });
  const auto source = open(server.address());
  int last = -1;
  for (int k = 0; k < 5; ++k) {
    const auto frame = read(*source);
    ASSERT_TRUE(frame);
    EXPECT_GT(test::number_of(frame->bgr), last);
    last = test::number_of(frame->bgr);
  }
}

TEST_F(NetworkCamera, DamagedPicturesAreLeftOutAndTold) {
  const LoopbackServer server([](Caller& caller) {
    (void)caller.request();
    bool there = test::send_multipart_head(caller);
    for (int k = 0; there; ++k) {
      auto jpeg = test::jpeg_of(test::numbered_picture(k));
      if (k % 2 == 1) std::fill(jpeg.begin() + 2, jpeg.begin() + 300, std::uint8_t(k));
      there = test::send_part(caller, jpeg) && caller.wait(20ms);
    }
  });
  const auto source = open(server.address());
  for (int k = 0; k < 10; ++k) {
    const auto frame = read(*source);
    ASSERT_TRUE(frame);
    EXPECT_EQ(test::number_of(frame->bgr) % 2, 0);
  }
  EXPECT_THAT(source->warnings(), ElementsAre(HasSubstr("damaged pictures")));
}

TEST_F(NetworkCamera, IsNoRecordingWhateverLengthTheServerDeclares) {
  const LoopbackServer server([](Caller& caller) {
    (void)caller.request();
    bool there = caller.send(
        "HTTP/1.0 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=next\r\n"
        "Content-Length: 99999999\r\n\r\n");
    for (int k = 0; there; ++k)
      there = test::send_part(caller, test::jpeg_of(test::numbered_picture(k))) && caller.wait(20ms);
  });
  const auto source = open(server.address());
  EXPECT_TRUE(read(*source));
  EXPECT_THAT(states(), ElementsAre("starting", "running"));
}

// A broadcast: no length, and times of its own.
test::Bytes transport_stream(const test::TempFolder& folder, int count) {
  test::VideoRecipe recipe;
  recipe.encoder = "mpeg2video";
  recipe.pixel_format = AV_PIX_FMT_YUV420P;
  recipe.format = "mpegts";
  recipe.width = 160;
  recipe.height = 96;
  recipe.time_base = {1, 25};
  recipe.times.clear();
  for (int i = 0; i < count; ++i) recipe.times.push_back(i);
  recipe.paint = [](AVFrame& frame, int index) { test::fill_plane(frame, 0, 40 + index % 100); };
  test::make_video(folder / "a.ts", recipe);
  return test::read_bytes(folder / "a.ts");
}

TEST_F(NetworkCamera, TimesAreTheSendersWhereTheStreamHasThem) {
  const test::TempFolder folder;
  const auto bytes = transport_stream(folder, 250);
  for (const std::string scheme : {"http", "tcp"}) {
    const LoopbackServer server([&](Caller& caller) {
      if (scheme == "http") {
        (void)caller.request();
        (void)caller.send("HTTP/1.0 200 OK\r\nContent-Type: video/mp2t\r\n\r\n");
      }
      // In bursts of uneven length, as networks have it, at about the speed of the pictures.
      const std::size_t portion = bytes.size() / 250;
      for (std::size_t at = 0, k = 1; at < bytes.size(); ++k) {
        const auto size = std::min(bytes.size() - at, portion * (k % 3 + 1));
        if (!caller.send(std::span(bytes).subspan(at, size)) || !caller.wait(40ms * (k % 3 + 1))) return;
        at += size;
      }
    });
    const auto source = open(server.address(scheme));
    EXPECT_NEAR(source->info().nominal_fps, 25, 0.01);
    FramePtr last;
    for (int k = 0; k < 40; ++k) {
      const auto frame = read(*source);
      ASSERT_TRUE(frame);
      if (k > 20) {
        const double passed = to_seconds(frame->device_time - last->device_time);
        EXPECT_NEAR(passed, 0.040 * double(frame->sequence - last->sequence), 0.010) << k;
      }
      last = frame;
    }
  }
}

class NetworkRecording : public NetworkTest {
 protected:
  // As web servers send files.
  static void serve_file(Caller& caller, const test::Bytes& bytes, bool ranges) {
    const auto request = caller.request();
    std::size_t begin = 0;
    const auto range = request.find("Range: bytes=");
    if (ranges && range != std::string::npos) begin = std::stoul(request.substr(range + 13));
    std::string head = begin > 0 ? "HTTP/1.1 206 Partial Content\r\n" : "HTTP/1.1 200 OK\r\n";
    head += "Content-Type: application/octet-stream\r\nConnection: close\r\n";
    if (ranges) head += "Accept-Ranges: bytes\r\n";
    if (begin > 0) {
      head += "Content-Range: bytes " + std::to_string(begin) + "-" + std::to_string(bytes.size() - 1) + "/" +
              std::to_string(bytes.size()) + "\r\n";
    }
    head += "Content-Length: " + std::to_string(bytes.size() - begin) + "\r\n\r\n";
    if (caller.send(head)) (void)caller.send(std::span(bytes).subspan(begin));
  }
};

TEST_F(NetworkRecording, IsReadToItsEndWithoutLosingAFrame) {
  const test::TempFolder folder;
  std::vector<cv::Mat> pictures;
  {
    outputs::VideoOptions options;
    options.rate = {25, 1};
    outputs::VideoWriter writer(folder / "a.mkv", {64, 48}, options);
    for (int k = 0; k < 120; ++k) {
      pictures.push_back(test::noise({64, 48}, CV_8UC3, std::uint64_t(k) + 1));
      writer.write(pictures.back(), std::chrono::milliseconds(40 * k));
    }
    writer.close();
  }
  const auto bytes = test::read_bytes(folder / "a.mkv");
  for (const bool ranges : {true, false}) {
    const LoopbackServer server([&](Caller& caller) { serve_file(caller, bytes, ranges); });
    const auto source = open(server.address() + "/a.mkv");
    const auto frames = test::all_frames(*source);
    ASSERT_EQ(frames.size(), pictures.size()) << ranges;
    for (std::size_t k = 0; k < frames.size(); ++k) {
      ASSERT_TRUE(test::same_pixels(frames[k]->bgr, pictures[k])) << k;
      EXPECT_EQ(frames[k]->device_time, std::chrono::milliseconds(40 * k)) << "the recording's own times";
    }
    EXPECT_THAT(source->warnings(), IsEmpty());
  }
}

TEST_F(NetworkRecording, AFileWithoutADurationIsOneByItsLength) {
  const test::TempFolder folder;
  const auto bytes = transport_stream(folder, 60);
  const LoopbackServer server([&](Caller& caller) { serve_file(caller, bytes, false); });
  const auto source = open(server.address() + "/a.ts");
  EXPECT_EQ(test::all_frames(*source).size(), 60U);
}

}  // namespace
}  // namespace choreo::devices
