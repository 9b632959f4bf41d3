// SPDX-License-Identifier: Apache-2.0
// Takes as a user makes them: recorded, interrupted, killed, and replayed to the same results to the last byte.
#include <algorithm>
#include <csignal>
#include <cstdarg>
#include <filesystem>
#include <memory>

#include <gmock/gmock.h>

#include "devices/take/take_format.hpp"
#include "end_to_end/refusal_fixture.hpp"
#include "support/eventually.hpp"
#include "support/make_video.hpp"
#include "support/places.hpp"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

namespace choreo::test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::SizeIs;
using ::testing::StartsWith;

class Record : public RefusalTest {
 protected:
  [[nodiscard]] std::string take() const { return folder_ / "take.mkv"; }
  [[nodiscard]] std::string unfinished() const { return folder_ / "take.unfinished.mkv"; }

  Outcome record(const std::string& source, const std::vector<std::string>& more = {}, int status = 0,
                 const RunOptions& options = {}) {
    std::vector<std::string> arguments{"record", source, "-o", take()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    auto run = choreoscope(arguments, options);
    EXPECT_EQ(run.status, status) << run.told();
    return run;
  }

  // What analyze makes of a source, without its pictures, which bear the source's name.
  std::map<std::string, Bytes> results_of(const std::string& source, const std::string& out,
                                          const std::vector<std::string>& more = {}) {
    analyze(source, out, more);
    return results_in(out);
  }

  static std::map<std::string, Bytes> results_in(const std::string& out) {
    std::map<std::string, Bytes> results;
    for (const auto* name : {"z.npy", "zstar.npy", "times.npy", "frames.csv"}) {
      results[name] = read_bytes(out + "/" + name);
    }
    return results;
  }

  static void expect_same(const std::map<std::string, Bytes>& a, const std::map<std::string, Bytes>& b) {
    for (const auto& [name, bytes] : a) EXPECT_TRUE(bytes == b.at(name)) << name;
  }

  // Runs live twice: recording, and from what it recorded.
  enum class Lost { kFrames, kMaybe };
  void expect_replay_is_the_same(const Outcome& live, const std::vector<std::string>& settings,
                                 Lost lost = Lost::kFrames) {
    ASSERT_EQ(live.status, 0) << live.told();
    ASSERT_THAT(live.err, HasSubstr("take.mkv: ")) << "the recording is told of";
    EXPECT_EQ(live.err.find("the take lacks"), std::string::npos) << live.told();
    const Results ran(folder_ / "live");
    EXPECT_GT(ran.n, 10u);
    if (lost == Lost::kFrames) {
      EXPECT_GT(ran.summary["timings"]["dropped"], 0) << "nothing was overtaken: the test proves nothing";
    }

    std::vector<std::string> arguments{
        "live", take() + "?frames=processed", "--headless", "--pace", "max", "--out", folder_ / "replay"};
    arguments.insert(arguments.end(), settings.begin(), settings.end());
    const auto replay = choreoscope(arguments);
    ASSERT_EQ(replay.status, 0) << replay.told();
    EXPECT_EQ(Results(folder_ / "replay").n, ran.n);
    expect_same(results_in(folder_ / "live"), results_in(folder_ / "replay"));
  }
};

TEST_F(Record, WhatIsRecordedGivesTheSameResultsAsTheSource) {
  constexpr auto kSource = "synthetic://walking?size=160x120&fps=15&duration=2&seed=3";
  const auto expected = results_of(kSource, folder_ / "source");
  for (const auto* codec : {"ffv1", "ffvhuff", "auto"}) {
    const auto run = record(kSource, {"--codec", codec, "--force"});
    EXPECT_THAT(run.out, MatchesRegex(".*take.mkv: 45 frames, 0 left out, 2.9 s, colour ffv(1|huff), [0-9.]+ MB\n"));
    expect_same(expected, results_of(take(), folder_ / codec));
  }
}

// As most players do it: by FFmpeg's libraries, which are told nothing of takes.
TEST_F(Record, OrdinaryPlayersReadIt) {
  record("synthetic://walking?size=160x120&fps=15&duration=1&empty=0");
  static std::string complaints;
  complaints.clear();
  av_log_set_callback([](void*, int level, const char* format, va_list) {
    if (level <= AV_LOG_WARNING) complaints += format;
  });
  AVFormatContext* opened = nullptr;
  ASSERT_EQ(avformat_open_input(&opened, take().c_str(), nullptr, nullptr), 0);
  const std::unique_ptr<AVFormatContext, void (*)(AVFormatContext*)> file(
      opened, [](AVFormatContext* f) { avformat_close_input(&f); });
  ASSERT_GE(avformat_find_stream_info(opened, nullptr), 0);
  const AVCodec* codec = nullptr;
  const int video = av_find_best_stream(opened, AVMEDIA_TYPE_VIDEO, -1, -1, &codec, 0);
  ASSERT_GE(video, 0);
  const std::unique_ptr<AVCodecContext, void (*)(AVCodecContext*)> decoder(
      avcodec_alloc_context3(codec), [](AVCodecContext* c) { avcodec_free_context(&c); });
  ASSERT_GE(avcodec_parameters_to_context(decoder.get(), opened->streams[video]->codecpar), 0);
  ASSERT_EQ(avcodec_open2(decoder.get(), codec, nullptr), 0);
  EXPECT_STREQ(codec->name, "ffv1");
  EXPECT_EQ(decoder->width, 160);

  const std::unique_ptr<AVPacket, void (*)(AVPacket*)> packet(av_packet_alloc(),
                                                              [](AVPacket* p) { av_packet_free(&p); });
  const std::unique_ptr<AVFrame, void (*)(AVFrame*)> frame(av_frame_alloc(), [](AVFrame* f) { av_frame_free(&f); });
  int frames = 0;
  const auto decode = [&](const AVPacket* next) {
    EXPECT_EQ(avcodec_send_packet(decoder.get(), next), 0);
    while (avcodec_receive_frame(decoder.get(), frame.get()) == 0) ++frames;
  };
  while (av_read_frame(opened, packet.get()) == 0) {
    if (packet->stream_index == video) decode(packet.get());
    av_packet_unref(packet.get());
  }
  decode(nullptr);
  av_log_set_callback(av_log_default_callback);
  EXPECT_EQ(frames, 15);
  EXPECT_EQ(complaints, "");
}

TEST_F(Record, ATakeBecomesADumpAndADumpATake) {
  constexpr auto kSource = "synthetic://walking?size=640x480&fps=10&duration=1&empty=0&depth=1";
  const auto made = record(kSource);
  EXPECT_THAT(made.out, HasSubstr("depth ffv"));
  const auto dumped = choreoscope({"record", take(), "-o", folder_ / "dump/"});
  ASSERT_EQ(dumped.status, 0) << dumped.told();
  EXPECT_THAT(dumped.out, HasSubstr("10 colour and 10 depth pictures"));
  const auto dump = "kinect-dump:" + (folder_ / "dump");
  const auto again = choreoscope({"record", dump + "?depth=raw", "-o", folder_ / "again.mkv"});
  ASSERT_EQ(again.status, 0) << again.told();
  expect_same(results_of(take(), folder_ / "a", {"--set", "segmentation=colour"}),
              results_of(folder_ / "again.mkv", folder_ / "b", {"--set", "segmentation=colour"}));
  expect_same(results_of(dump + "?depth=raw", folder_ / "c", {"--set", "segmentation=depth"}),
              results_of(folder_ / "again.mkv", folder_ / "d", {"--set", "segmentation=depth"}));

  const auto small = choreoscope({"record", "synthetic://walking?size=160x120&duration=1", "-o", folder_ / "small/"});
  EXPECT_THAT(complaint_of(small, 2), HasSubstr("160x120"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "small"));
  const auto taken = choreoscope({"record", take(), "-o", folder_ / "dump/"});
  EXPECT_THAT(complaint_of(taken, 2), HasSubstr("dump"));
}

TEST_F(Record, TheDurationEndsIt) {
  const auto run = record("synthetic://walking?size=64x48&fps=10&duration=60", {"--duration", "1.5s"});
  EXPECT_THAT(run.out, HasSubstr("take.mkv: 15 frames"));
}

TEST_F(Record, ATurnedSourceStaysTurned) {
  constexpr auto kSource = "synthetic://walking?size=160x120&fps=15&duration=1&rotate=90&flip=vertical";
  record(kSource);
  expect_same(results_of(kSource, folder_ / "a"), results_of(take(), folder_ / "b"));
}

TEST_F(Record, WhatCannotBeIsRefusedAndNothingIsLeft) {
  write_bytes(take(), std::string("precious"));
  const auto refuse = [&](const std::string& source, const std::vector<std::string>& more, const std::string& out) {
    std::vector<std::string> arguments{"record", source, "-o", out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto run = choreoscope(arguments);
    const auto complaint = complaint_of(run, 2);
    EXPECT_EQ(read_bytes(take()).size(), 8u) << "precious";
    EXPECT_EQ(files_in(folder_.path()).size(), 10u) << "something was left behind";  // Nine in old and beside it.
    return complaint + " " + hint_of(run);
  };
  EXPECT_THAT(refuse(kQuick, {}, take()), AllOf(HasSubstr("is there already"), HasSubstr("--force")));
  EXPECT_THAT(refuse(kQuick, {}, folder_ / "take.avi"), HasSubstr("does not end in .mkv"));
  EXPECT_THAT(refuse(kQuick, {}, folder_ / "no/take.mkv"), HasSubstr("is no folder"));
  const auto other = folder_ / "other.mkv";
  EXPECT_THAT(refuse(kQuick, {"--codec", "h264"}, other), AllOf(HasSubstr("--codec"), HasSubstr("ffvhuff")));
  EXPECT_THAT(refuse(kQuick, {"--streams", "sound"}, other), HasSubstr("colour,depth"));
  EXPECT_THAT(refuse(kQuick, {"--streams", "colour,"}, other), HasSubstr("--streams"));
  EXPECT_THAT(refuse(kQuick, {"--duration", "0s"}, other), HasSubstr("--duration"));
  EXPECT_THAT(refuse(kQuick, {"--duration", "long"}, other), HasSubstr("--duration"));
  EXPECT_THAT(refuse("nowhere.mkv", {}, other), HasSubstr("does not exist"));
}

TEST_F(Record, ASourceWithoutTheStreamIsAFailureAndLeavesNothing) {
  const auto run = record(kQuick, {"--streams", "depth"}, 1);
  EXPECT_THAT(complaint_of(run, 1), HasSubstr("none of the pictures"));
  EXPECT_FALSE(std::filesystem::exists(take()));
  EXPECT_FALSE(std::filesystem::exists(unfinished()));
}

// Sends a signal once the unfinished take has grown to so many bytes.
RunOptions signalled(const std::string& file, int signal) {
  RunOptions options;
  options.started = [file, signal](int process) {
    EXPECT_TRUE(eventually([&] {
      std::error_code problem;
      const auto bytes = std::filesystem::file_size(file, problem);
      return !problem && bytes > 300'000;
    }));
    ::kill(process, signal);
  };
  return options;
}

constexpr auto kLong = "synthetic://walking?size=160x120&fps=30&duration=600";

TEST_F(Record, CtrlCFinishesTheTake) {
  const auto run = record(kLong, {}, 130, signalled(unfinished(), SIGINT));
  EXPECT_THAT(run.err_lines("choreoscope: warning: interrupted"), SizeIs(1));
  EXPECT_THAT(run.out, HasSubstr("take.mkv: "));
  EXPECT_FALSE(std::filesystem::exists(unfinished()));
  const auto again = analyze(take(), folder_ / "out");
  EXPECT_TRUE(again.err_lines("choreoscope: warning: \"").empty()) << again.told();
}

TEST_F(Record, KilledInTheMiddleItIsGoodUpToTheEnd) {
  const auto run = choreoscope({"record", kLong, "-o", take()}, signalled(unfinished(), SIGKILL));
  EXPECT_EQ(run.signal, SIGKILL);
  EXPECT_FALSE(std::filesystem::exists(take()));
  const auto size = std::filesystem::file_size(unfinished());
  const auto read = analyze(unfinished(), folder_ / "out");
  EXPECT_THAT(read.err, HasSubstr("was cut off"));
  const Results cut(folder_ / "out");
  // Every frame that is wholly in the file comes back; the largest is below 40 kB.
  EXPECT_GT(cut.n * 40'000, size - 40'000);
  analyze(kLong, folder_ / "source", {"--span", "1f:" + std::to_string(cut.n) + "f", "--background", "first:1s"});
  analyze(unfinished(), folder_ / "first", {"--background", "first:1s"});
  expect_same(results_in(folder_ / "source"), results_in(folder_ / "first"));
}

TEST_F(Record, AFullDiskIsAFailureAndWhatCameBeforeIsGood) {
  RunOptions full;
  full.file_size_limit = 300'000;
  const auto run = record(kLong, {}, 1, full);
  EXPECT_THAT(complaint_of(run, 1), HasSubstr("broke off after"));
  EXPECT_THAT(hint_of(run), HasSubstr("take.unfinished.mkv"));
  analyze(unfinished(), folder_ / "out");
  EXPECT_GT(Results(folder_ / "out").n, 5u);
}

// Slow enough that frames are overtaken on any machine. At 240 frames a second the default history is a gigabyte.
const std::vector<std::string> kSlow = {"--set", "working.rows=0", "--set", "mask.steps=32", "--history", "5s"};

TEST_F(Record, ALiveRunThatDropsFramesIsReplayedByteForByte) {
  record("synthetic://jumping-jacks?size=320x240&fps=240&duration=1&empty=1&noise=1", {"--codec", "ffvhuff"});
  std::filesystem::rename(take(), folder_ / "camera.mkv");
  std::vector<std::string> arguments{
      "live", folder_ / "camera.mkv", "--headless", "--out", folder_ / "live", "--record", take()};
  arguments.insert(arguments.end(), kSlow.begin(), kSlow.end());
  expect_replay_is_the_same(choreoscope(arguments), kSlow);
}

TEST_F(Record, ARunFromASourceThatGivesItsFramesOnceIsReplayedByteForByte) {
  // A frame a millisecond: they come as fast as they are decoded.
  VideoRecipe recipe;
  recipe.encoder = "mpeg4";
  recipe.pixel_format = AV_PIX_FMT_YUV420P;
  recipe.width = 320;
  recipe.height = 240;
  recipe.times.clear();
  for (int k = 0; k < 400; ++k) recipe.times.push_back(k);
  recipe.paint = [](AVFrame& frame, int index) {
    for (int plane = 0; plane < 3; ++plane) fill_plane(frame, plane, plane == 0 ? 90 : 128);
    if (index < 100) return;
    for (int y = 40; y < 220; ++y) {  // Somebody walks through the picture.
      std::fill_n(frame.data[0] + std::ptrdiff_t{y} * frame.linesize[0] + 2 * (index - 100) / 3, 80, std::uint8_t{200});
    }
  };
  const auto clip = folder_ / "clip.mkv";
  make_video(clip, recipe);
  for (const auto* background : {"auto", "first:0.1s"}) {
    SCOPED_TRACE(background);
    auto settings = kSlow;
    settings.insert(settings.end(), {"--background", background, "--every", "2"});
    std::string more;
    for (const auto& word : settings) more += " '" + word + "'";
    const auto pipe = folder_ / (std::string("pipe-") + background[0]);
    const auto script = "cat " + clip + " > " + pipe + " & exec " + program() + " live " + pipe + " --headless --out " +
                        (folder_ / "live") + " --record " + take() + more;
    // The shell makes the pipe before it becomes the program.
    expect_replay_is_the_same(run_program("/bin/sh", {"-c", "mkfifo " + pipe + "; " + script}), settings);
    std::filesystem::remove(take());
  }
}

TEST_F(Record, ALiveRunWithDepthIsReplayedByteForByte) {
  // More frames a second than can be looked at, on quick machines too.
  record("synthetic://jumping-jacks?size=320x240&fps=240&duration=0.4&empty=0.4&depth=1", {"--codec", "ffvhuff"});
  std::filesystem::rename(take(), folder_ / "camera.mkv");
  for (const auto* segmentation : {"depth", "both"}) {
    SCOPED_TRACE(segmentation);
    auto settings = kSlow;
    settings.insert(settings.end(), {"--set", std::string("segmentation=") + segmentation});
    std::vector<std::string> arguments{
        "live", folder_ / "camera.mkv", "--headless", "--out", folder_ / "live", "--record", take()};
    arguments.insert(arguments.end(), settings.begin(), settings.end());
    expect_replay_is_the_same(choreoscope(arguments), settings);
    std::filesystem::remove(take());
  }
}

// A search for faces that is due at the next frame, 8 ms later, is not always done by then.
TEST_F(Record, ALiveRunThatMissesFacesIsReplayedByteForByte) {
  record("synthetic://semaphore?text=R&size=320x240&fps=120&duration=1.5&empty=2.1&skin=light", {"--codec", "ffvhuff"});
  std::filesystem::rename(take(), folder_ / "camera.mkv");
  const std::vector<std::string> settings = {"--recognise", "semaphore", "--set", "face.delay_frames=1"};
  std::vector<std::string> arguments{
      "live", folder_ / "camera.mkv", "--headless", "--out", folder_ / "live", "--record", take()};
  arguments.insert(arguments.end(), settings.begin(), settings.end());
  const auto run = choreoscope(arguments);
  expect_replay_is_the_same(run, settings, Lost::kMaybe);
  EXPECT_THAT(run.err_lines("choreoscope: warning: "),
              Contains(HasSubstr("searches for faces were not ready in time")));
  EXPECT_TRUE(read_bytes(folder_ / "live" + "/letters.json") == read_bytes(folder_ / "replay" + "/letters.json"));
  const auto bytes = read_bytes(take());
  const std::string mark = devices::take::kLateFaceMark;
  EXPECT_NE(std::search(bytes.begin(), bytes.end(), mark.begin(), mark.end()), bytes.end())
      << "no search was late: the test proves nothing";
}

TEST_F(Record, AReplayWithOtherSettingsSaysSo) {
  ASSERT_EQ(choreoscope({"live", kQuick, "--headless", "--pace", "max", "--record", take()}).status, 0);
  const auto replayed = [&](const std::vector<std::string>& settings) {
    std::vector<std::string> arguments{"live", take() + "?frames=processed", "--headless", "--pace", "max"};
    arguments.insert(arguments.end(), settings.begin(), settings.end());
    return choreoscope(arguments).err_lines("choreoscope: warning: the run that recorded this had other settings");
  };
  EXPECT_TRUE(replayed({}).empty());
  EXPECT_TRUE(replayed({"--set", "plot.width_px=320"}).empty()) << "of no consequence";
  const auto told = replayed({"--set", "mask.steps=2"});
  ASSERT_THAT(told, SizeIs(1));
  EXPECT_THAT(told[0], HasSubstr("mask.steps was 1 and is 2"));
}

// A pipe gives its frames once: they are in the take before the run turns out to be none.
TEST_F(Record, ARunThatIsRefusedLeavesNoTake) {
  const auto clip = folder_ / "clip.mkv";
  ASSERT_EQ(choreoscope({"synth", "walking?size=160x120&duration=2", "-o", clip}).status, 0);
  const auto pipe = folder_ / "pipe";
  const auto run =
      run_program("/bin/sh", {"-c", "mkfifo " + pipe + "; cat " + clip + " > " + pipe + " & exec " + program() +
                                        " live " + pipe + " --headless --set segmentation=depth --record " + take()});
  EXPECT_THAT(complaint_of(run, 2), HasSubstr("has no depth"));
  EXPECT_FALSE(std::filesystem::exists(take()));
  EXPECT_FALSE(std::filesystem::exists(unfinished()));
}

TEST_F(Record, ADumpOfATurnedDumpHasDepthWhereItsColoursAre) {
  const auto dumped = [&](const std::string& source, const std::string& to) {
    const auto run = choreoscope({"record", source, "-o", folder_ / to + "/"});
    EXPECT_EQ(run.status, 0) << run.told();
    return "kinect-dump:" + (folder_ / to);
  };
  const auto first = dumped("synthetic://walking?size=640x480&fps=10&duration=1&empty=1&depth=1", "a");
  const auto turned = first + "?depth=raw&rotate=180&flip=horizontal";
  const std::vector<std::string> by_depth = {"--set", "segmentation=depth", "--background", "first:1s"};
  expect_same(results_of(turned, folder_ / "c", by_depth),
              results_of(dumped(turned, "b") + "?depth=raw", folder_ / "d", by_depth));

  const auto refused = choreoscope({"record", first, "-o", folder_ / "e/", "--codec", "ffv1"});
  EXPECT_THAT(complaint_of(refused, 2), AllOf(HasSubstr("--codec"), HasSubstr("takes")));
}

TEST_F(Record, ALiveRunGoesOnWhereTheRecordingBreaksOffAndSaysSo) {
  RunOptions full;
  full.file_size_limit = 200'000;
  const auto run = choreoscope(
      {"live", "synthetic://walking?size=160x120&fps=15&duration=2", "--headless", "--pace", "max", "--record", take()},
      full);
  EXPECT_EQ(run.status, 1) << run.told();
  EXPECT_THAT(run.err_lines("choreoscope: warning: the recording broke off, the run goes on"), SizeIs(1));
  EXPECT_EQ(run.out, "45 frames, 30 with a body\n") << "the run itself is whole";
  EXPECT_THAT(run.err_lines("choreoscope: error: the recording broke off"), SizeIs(1));
}

TEST_F(Record, LiveRefusesToRecordOverSomething) {
  write_bytes(take(), std::string("precious"));
  const auto run = choreoscope({"live", kQuick, "--headless", "--record", take()});
  EXPECT_THAT(complaint_of(run, 2), HasSubstr("is there already"));
  EXPECT_EQ(read_bytes(take()).size(), 8u);
  EXPECT_THAT(complaint_of(choreoscope({"live", kQuick, "--headless", "--record", ""}), 2), StartsWith("--record"));
}

}  // namespace
}  // namespace choreo::test
