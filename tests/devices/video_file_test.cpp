// SPDX-License-Identifier: Apache-2.0
// What is delivered of a sound recording, and which files are none.
#include <gmock/gmock.h>

#include <sys/stat.h>
#include <unistd.h>

#include <utility>

#include <opencv2/imgcodecs.hpp>

#include "devices/video_fixture.hpp"
#include "support/shared_data.hpp"

namespace choreo::devices {
namespace {

using test::all_frames;
using test::make_video;
using test::same_pixels;
using test::VideoRecipe;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST_F(VideoFileTest, VariableFrameRateIsKeptToTheMillisecond) {
  const std::vector<int> times_ms = {0, 17, 50, 51, 400, 3000};
  outputs::VideoWriter writer(folder_ / "a.mkv", {8, 8});
  for (const int t : times_ms) writer.write(cv::Mat::zeros(8, 8, CV_8UC3), std::chrono::milliseconds(t));
  writer.close();
  const auto source = open("a.mkv");
  const auto frames = all_frames(*source);
  ASSERT_EQ(frames.size(), times_ms.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i]->device_time, std::chrono::milliseconds(times_ms[i]));
    EXPECT_EQ(frames[i]->sequence, i);
  }
  EXPECT_THAT(source->warnings(), IsEmpty());
}

TEST_F(VideoFileTest, TimesFinerThanAMillisecondAreKeptWhereTheFileHasThem) {
  VideoRecipe recipe;
  recipe.encoder = "png";
  recipe.pixel_format = AV_PIX_FMT_RGB24;
  recipe.time_base = {1, 30000};
  recipe.times = {0, 1001, 2002, 4004};
  make_video(folder_ / "a.mov", recipe);
  const auto frames = all_frames(*open("a.mov"));
  ASSERT_EQ(frames.size(), 4u);
  EXPECT_EQ(frames[1]->device_time.count(), 33'366'667);
  EXPECT_EQ(frames[3]->device_time.count(), 133'466'667);
}

TEST_F(VideoFileTest, LosslessPixelsComeBackExactly) {
  for (const bool grey : {false, true}) {
    for (const cv::Size size : {cv::Size(1, 1), {2, 1}, {33, 17}, {161, 99}, {640, 48}}) {
      const auto pictures = write_noise("a.mkv", 3, size, grey);
      const auto source = open("a.mkv");
      EXPECT_EQ(source->info().size, size);
      const auto frames = all_frames(*source);
      ASSERT_EQ(frames.size(), 3u);
      for (unsigned i = 0; i < 3; ++i) {
        cv::Mat expected = pictures[i];
        if (grey) cv::merge(std::vector<cv::Mat>(3, pictures[i]), expected);
        EXPECT_TRUE(same_pixels(frames[i]->bgr, expected)) << size << (grey ? " grey " : " colour ") << i;
      }
    }
  }
}

TEST_F(VideoFileTest, TheSourceSaysWhatItIs) {
  write_noise("a.mkv", 10);
  const auto source = open("a.mkv");
  EXPECT_EQ(source->info().name, folder_ / "a.mkv");
  EXPECT_EQ(source->info().size, cv::Size(24, 16));
  EXPECT_DOUBLE_EQ(source->info().nominal_fps, 25.0);
  EXPECT_EQ(source->info().duration, std::chrono::milliseconds(400));
  EXPECT_TRUE(source->info().repeatable);
  EXPECT_EQ(all_frames(*source).size(), 10u);
  EXPECT_EQ(source->read({}), nullptr) << "the end stays the end";
}

TEST_F(VideoFileTest, SkimmedFramesLackTheirPictureAlone) {
  write_noise("a.mkv", 4);
  const auto frames = all_frames(*open("a.mkv"));
  const auto source = open("a.mkv");
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const auto frame = k % 2 == 0 ? source->skim({}) : source->read({});
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->sequence, frames[k]->sequence);
    EXPECT_EQ(frame->device_time, frames[k]->device_time);
    EXPECT_TRUE(k % 2 == 0 ? frame->bgr.empty() : same_pixels(frame->bgr, frames[k]->bgr)) << k;
  }
  EXPECT_FALSE(source->skim({}));
}

// FFmpeg gives the tick of a clock where it knows of no rate, and the coarsest one that times fall on.
TEST_F(VideoFileTest, ATickIsNoFrameRate) {
  VideoRecipe recipe;
  const auto fps_of = [&](const std::string& name, const char* encoder, AVRational time_base,
                          std::vector<std::int64_t> times) {
    recipe.encoder = encoder;
    recipe.pixel_format = std::string(encoder) == "ffv1" ? AV_PIX_FMT_BGR0 : AV_PIX_FMT_YUV420P;
    recipe.time_base = time_base;
    recipe.times = std::move(times);
    make_video(folder_ / name, recipe);
    return open(name)->info().nominal_fps;
  };
  const auto every = [](std::int64_t step) {
    std::vector<std::int64_t> times;
    for (int i = 0; i < 40; ++i) times.push_back(i * step);
    return times;
  };
  auto uneven = every(40);
  for (std::size_t i = 1; i < uneven.size(); i += 3) uneven[i] += 10;
  auto jittered = every(33);
  for (std::size_t i = 1; i < jittered.size(); i += 3) jittered[i] += 1;
  const AVRational ms{1, 1000};
  for (const auto& [name, encoder] : {std::pair("a.mkv", "ffv1"), {"b.mkv", "mpeg4"}, {"a.flv", "flv"}}) {
    EXPECT_EQ(fps_of(name, encoder, ms, {0, 40, 80}), 0) << name;
    EXPECT_EQ(fps_of(name, encoder, ms, uneven), 0) << name << ", whose times fall on a hundredth of a second";
    EXPECT_EQ(fps_of(name, encoder, ms, jittered), 0) << name;
  }
  EXPECT_EQ(fps_of("a.nut", "mpeg4", ms, uneven), 0);
  if (test::has_encoder("libvpx")) {
    EXPECT_EQ(fps_of("a.webm", "libvpx", ms, jittered), 0);
    EXPECT_EQ(fps_of("a.ivf", "libvpx", {1, 500}, every(20)), 0) << "a tick that FFmpeg takes for a frame";
  }

  EXPECT_EQ(fps_of("a.avi", "ffv1", ms, every(1)), 1000) << "its head says so";
  EXPECT_EQ(fps_of("b.avi", "ffv1", {1, 500}, every(1)), 500);
  EXPECT_EQ(fps_of("c.avi", "ffv1", {1, 25}, every(1)), 25);
  recipe.duration = 1;
  EXPECT_EQ(fps_of("a.mp4", "mpeg4", ms, every(1)), 1000) << "so do its lengths";
  recipe.duration = 0;
  recipe.rate = {25, 1};
  EXPECT_EQ(fps_of("c.mkv", "ffv1", ms, jittered), 25);
  EXPECT_EQ(fps_of("b.flv", "flv", ms, jittered), 25);
  recipe.rate = {500, 1};
  EXPECT_EQ(fps_of("d.mkv", "ffv1", ms, every(2)), 500) << "the highest that FFmpeg writes into it";
  recipe.rate = {1000, 1};
  EXPECT_EQ(fps_of("c.flv", "flv", ms, every(1)), 1000);
}

TEST_F(VideoFileTest, ABrowsersRecordingDeclaresNoRate) {
  const auto path = test::shared_data("cases/chrome.webm");
  if (path.empty()) GTEST_SKIP() << "the shared recordings are not here; set CHOREO_SHARED_DATA";
  EXPECT_EQ(registry_.open(path)->info().nominal_fps, 0);
}

TEST_F(VideoFileTest, FramesAreTheSameForAnyNumberOfThreads) {
  struct Case {
    const char* encoder;
    const char* name;
  };
  for (const auto& [encoder, name] : {Case{"libx264", "a.mp4"}, Case{"mpeg4", "b.mp4"}, Case{"ffv1", "c.mkv"}}) {
    ASSERT_TRUE(test::has_encoder(encoder)) << "this FFmpeg has no " << encoder;
    VideoRecipe recipe;
    recipe.encoder = encoder;
    recipe.pixel_format = AV_PIX_FMT_YUV420P;
    recipe.width = 96;
    recipe.height = 64;
    recipe.times.clear();
    for (int i = 0; i < 40; ++i) recipe.times.push_back(40 * i);
    recipe.paint = [](AVFrame& frame, int index) {
      for (int plane = 0; plane < 3; ++plane) {
        for (int i = 0; i < frame.linesize[plane] * (plane == 0 ? 64 : 32); ++i) {
          frame.data[plane][i] = static_cast<std::uint8_t>((i * 7 + index * 11 + (i >> 5) * plane) % 219 + 16);
        }
      }
    };
    make_video(folder_ / name, recipe);
    const auto one = all_frames(*open(name, 1));
    ASSERT_EQ(one.size(), 40u) << encoder;
    for (const int threads : {0, 2, 4, 7}) {
      const auto many = all_frames(*open(name, threads));
      ASSERT_EQ(many.size(), one.size()) << encoder;
      for (std::size_t i = 0; i < one.size(); ++i) {
        EXPECT_EQ(one[i]->device_time, many[i]->device_time);
        ASSERT_TRUE(same_pixels(one[i]->bgr, many[i]->bgr)) << encoder << " frame " << i << " threads " << threads;
      }
    }
  }
}

TEST_F(VideoFileTest, ANameFullOfSignsIsStillAName) {
  for (const auto* name : {"img%03d.mkv", "a:b.mkv", "what?.mkv", "50%20off.mkv", "*[x]{y}.mkv", "-i.mkv"}) {
    write_noise(name, 1);
    EXPECT_EQ(all_frames(*open(name)).size(), 1u) << name;
  }
  // FFmpeg's own reader of picture sequences would take this name for a pattern.
  ASSERT_TRUE(cv::imwrite(folder_ / "img%d.png", cv::Mat(4, 4, CV_8UC3, cv::Scalar(1, 2, 3))));
  EXPECT_EQ(all_frames(*open("img%d.png")).size(), 1u);
}

TEST_F(VideoFileTest, AChangeOfSizeIsAFailureThatNamesBothSizesAndTheTime) {
  VideoRecipe recipe;
  recipe.format = "mjpeg";
  recipe.encoder = "mjpeg";
  recipe.pixel_format = AV_PIX_FMT_YUVJ420P;
  recipe.time_base = {1, 25};
  recipe.times = {0, 1, 2};
  recipe.width = 64;
  recipe.height = 48;
  make_video(folder_ / "a.mjpeg", recipe);
  recipe.width = 32;
  recipe.height = 24;
  make_video(folder_ / "b.mjpeg", recipe);
  auto joined = test::read_bytes(folder_ / "a.mjpeg");
  const auto second = test::read_bytes(folder_ / "b.mjpeg");
  joined.insert(joined.end(), second.begin(), second.end());
  test::write_bytes(folder_ / "joined.mjpeg", joined);

  const auto source = open("joined.mjpeg");
  for (int i = 0; i < 3; ++i) EXPECT_NE(source->read({}), nullptr);
  const auto error = test::error_of([&] { (void)source->read({}); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->fault(), Fault::kFailure);
  EXPECT_THAT(error->what(), HasSubstr("from 64x48 to 32x24 at 0.120 s"));
  EXPECT_EQ(source->read({}), nullptr) << "after a failure the source has ended";
}

TEST_F(VideoFileTest, MissingTimesAreMendedAndCounted) {
  ASSERT_TRUE(test::has_encoder("libx264")) << "this FFmpeg has no libx264";
  VideoRecipe recipe;
  recipe.format = "h264";  // A bare stream has no times.
  recipe.encoder = "libx264";
  recipe.pixel_format = AV_PIX_FMT_YUV420P;
  recipe.time_base = {1, 25};
  recipe.times = {0, 1, 2, 3, 4, 5, 6, 7};
  make_video(folder_ / "a.h264", recipe);
  const auto source = open("a.h264");
  const auto frames = all_frames(*source);
  ASSERT_EQ(frames.size(), 8u);
  for (std::size_t i = 1; i < 8; ++i) {
    EXPECT_EQ(frames[i]->device_time - frames[i - 1]->device_time, std::chrono::milliseconds(40));
  }
  EXPECT_THAT(source->warnings(), ElementsAre(HasSubstr("of 8 time stamps were missing")));
}

TEST_F(VideoFileTest, TextIsNotAVideo) {
  test::write_bytes(folder_ / "notes.txt", std::string(5000, 'x') + "\nDear diary\n");
  EXPECT_THAT(refusal("notes.txt").what(), HasSubstr("is text, not a video"));
  for (const auto* name : {"notes.nfo", "notes.ans", "notes.bin", "notes.xb", "notes.adf", "notes.idf"}) {
    test::write_bytes(folder_ / name, std::string(5000, 'x') + "\nDear diary\n");
    (void)refusal(name);
  }
}

TEST_F(VideoFileTest, SoundAloneIsNotAVideo) {
  // A WAV file by hand: 8000 Hz, one channel, 8 bit, 800 bytes of silence.
  const std::string head(
      "RIFF\x44\x03\0\0WAVEfmt \x10\0\0\0\x01\0\x01\0\x40\x1f\0\0\x40\x1f\0\0\x01\0\x08\0data\x20\x03\0\0", 44);
  test::write_bytes(folder_ / "a.wav", head + std::string(800, '\x80'));
  EXPECT_THAT(refusal("a.wav").what(), AllOf(HasSubstr("has no video"), HasSubstr("wav")));
}

TEST_F(VideoFileTest, ACoverPictureIsNotAVideo) {
  // An MP3 file by hand: an ID3v2.3 tag with one APIC frame, then silent frames of 417 bytes.
  ASSERT_TRUE(cv::imwrite(folder_ / "cover.png", cv::Mat(8, 8, CV_8UC3, cv::Scalar(1, 2, 3))));
  const auto png = test::read_bytes(folder_ / "cover.png");
  std::string body = std::string("\0image/png\0\x03\0", 13) + std::string(png.begin(), png.end());
  const auto number = [](std::size_t n, int bits) {
    std::string out;
    for (int i = 3; i >= 0; --i) out += static_cast<char>(n >> (i * bits) & ((1u << bits) - 1));
    return out;
  };
  const std::string frame = "APIC" + number(body.size(), 8) + std::string(2, '\0') + body;
  std::string file = std::string("ID3\x03\0\0", 6) + number(frame.size(), 7) + frame;
  for (int i = 0; i < 20; ++i) file += std::string("\xff\xfb\x90\x00", 4) + std::string(413, '\0');
  test::write_bytes(folder_ / "song.mp3", file);
  EXPECT_THAT(refusal("song.mp3").what(), AllOf(HasSubstr("has no video"), HasSubstr("cover picture")));
}

TEST_F(VideoFileTest, WhatCannotBeReadSaysWhy) {
  test::write_bytes(folder_ / "empty.mp4", std::string());
  EXPECT_THAT(refusal("empty.mp4").what(), HasSubstr("empty.mp4\" is empty"));
  EXPECT_THAT(refusal("none.mp4").what(), HasSubstr("none.mp4\" does not exist"));

  test::write_bytes(folder_ / "noise.mp4",
                    std::vector<std::uint8_t>(test::noise({100, 100}, CV_8UC1, 4).reshape(1, 1)));
  EXPECT_THAT(refusal("noise.mp4").what(),
              HasSubstr("is not a video that FFmpeg can read: Invalid data found when processing input"));

  const SourceUri uri{folder_.path(), "file", folder_.path(), {}};
  SettingReader settings(uri);
  const auto folder = test::error_of([&] { (void)video_file_driver().open(uri, settings, {}); });
  ASSERT_TRUE(folder);
  EXPECT_THAT(folder->what(), HasSubstr("is a folder"));
}

TEST_F(VideoFileTest, AFileWithoutPermissionSaysSo) {
  write_noise("a.mkv", 1);
  const bool root = ::geteuid() == 0;
  ASSERT_EQ(::chmod(folder_.path().c_str(), 0755), 0);
  ASSERT_EQ(::chmod((folder_ / "a.mkv").c_str(), 0), 0);
  ASSERT_EQ(root ? ::seteuid(65534) : 0, 0);
  const auto error = refusal("a.mkv");
  ASSERT_EQ(root ? ::seteuid(0) : 0, 0);
  EXPECT_THAT(error.what(), HasSubstr("cannot be read: Permission denied"));
}

TEST_F(VideoFileTest, AVideoWithoutFramesIsRefused) {
  outputs::VideoWriter(folder_ / "a.mkv", {8, 8}).close();
  EXPECT_THAT(refusal("a.mkv").what(), HasSubstr("a.mkv"));
}

TEST_F(VideoFileTest, UnknownSettingsAreRefusedBeforeTheFileIsOpened) {
  write_noise("a.mkv", 1);
  EXPECT_THAT(refusal("a.mkv?fps=3").what(), HasSubstr("unknown setting \"fps\""));
  EXPECT_EQ(open("a.mkv?rotate=90&flip=both")->info().size, cv::Size(16, 24));
}

TEST_F(VideoFileTest, NothingIsPrinted) {
  ::testing::internal::CaptureStderr();
  ::testing::internal::CaptureStdout();
  write_noise("a.mkv", 5);
  auto bytes = test::read_bytes(folder_ / "a.mkv");
  bytes[bytes.size() / 2] ^= 0x55;
  bytes.resize(bytes.size() * 3 / 4);
  test::write_bytes(folder_ / "a.mkv", bytes);
  (void)all_frames(*open("a.mkv"));
  test::write_bytes(folder_ / "b.mp4", bytes.size() > 99 ? test::Bytes(99, 7) : bytes);
  (void)refusal("b.mp4");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
}

TEST_F(VideoFileTest, RecordingsOfPeopleOpenUprightAndWhole) {
  for (const auto* name : {"pose2sim_single_cam01.mp4", "pose2sim_single_cam02.mp4"}) {
    const auto path = test::shared_data("video/clear/" + std::string(name));
    if (path.empty()) GTEST_SKIP() << "the shared recordings are not here; set CHOREO_SHARED_DATA";
    const auto source = registry_.open(path);
    EXPECT_EQ(source->info().size, cv::Size(1080, 1920));
    EXPECT_NEAR(source->info().nominal_fps, 60.0, 0.01);
    std::uint64_t count = 0;
    Nanoseconds last{-1};
    while (const auto frame = source->read({})) {
      EXPECT_EQ(frame->bgr.size(), source->info().size);
      EXPECT_GT(frame->device_time, last);
      last = frame->device_time;
      ++count;
    }
    EXPECT_EQ(count, 100u);
    EXPECT_EQ(last, Nanoseconds(1'650'000'000));
    EXPECT_THAT(source->warnings(), IsEmpty());
  }
}

}  // namespace
}  // namespace choreo::devices
