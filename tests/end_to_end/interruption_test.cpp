// SPDX-License-Identifier: Apache-2.0
// Ctrl-C: at any moment the program ends by itself, with what it has or with nothing, never with halves.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <thread>

#include <gmock/gmock.h>

#include "end_to_end/refusal_fixture.hpp"
#include "support/places.hpp"

namespace choreo::test {
namespace {

using ::testing::HasSubstr;

class Interruption : public RefusalTest {
 protected:
  static constexpr int kKilled = 130;
  // Long enough that no signal comes too late: several seconds of filming after each of the lines waited for.
  static constexpr auto kLong = "synthetic://walking?size=160x120&duration=30";

  Outcome poked(const std::string& source, const std::vector<Poke>& pokes, const std::vector<std::string>& more = {}) {
    RunOptions options;
    options.pokes = pokes;
    std::vector<std::string> arguments{"analyze", source, "--out", old()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    auto run = choreoscope(arguments, options);
    EXPECT_EQ(run.poked, pokes.size()) << run.told();
    EXPECT_EQ(run.status, kKilled) << run.told();
    EXPECT_TRUE(run.err_lines("choreoscope: error: ").empty()) << run.told();
    return run;
  }

  void expect_what_was_read(std::size_t all_frames) {
    const Results r(old());
    EXPECT_EQ(files_in(old()).size(), 8u);
    EXPECT_GT(r.n, 0u);
    EXPECT_LT(r.n, all_frames);
    EXPECT_EQ(r.summary["interrupted"], true);
    EXPECT_EQ(r.summary["frames"], r.n);
    EXPECT_EQ(r.z.shape, (std::vector<std::size_t>{r.n, r.n}));
    EXPECT_EQ(read_npy(old() + "/masks.npy").shape.at(0), r.n);
    EXPECT_FALSE(cv::imread(old() + "/plot.png").empty());
  }
};

TEST_F(Interruption, WhileLearningTheBackgroundLeavesNothing) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const auto run = poked(kLong, {{"learning the background: 20 %", signal}});
    EXPECT_THAT(run.err, HasSubstr("nothing was written"));
    EXPECT_EQ(run.out, "");
    expect_old_results();
  }
}

TEST_F(Interruption, WhileReadingFramesWritesWhatWasRead) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const auto run = poked(kLong, {{"reading frames: 20 %", signal}}, {"--save", "masks"});
    EXPECT_THAT(run.err_lines("choreoscope: warning: interrupted"), ::testing::SizeIs(1)) << run.told();
    expect_what_was_read(930);
  }
}

TEST_F(Interruption, WhileReadingFramesWithOneThreadWritesWhatWasRead) {
  poked(kLong, {{"reading frames: 20 %", SIGINT}}, {"--save", "masks", "--threads", "1"});
  expect_what_was_read(930);
}

TEST_F(Interruption, TwiceLeavesNothing) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const auto run = poked(kLong, {{"reading frames: 40 %", signal}, {"again to leave nothing", signal}});
    EXPECT_EQ(run.out, "");
    expect_old_results();
  }
}

TEST_F(Interruption, TwiceWhileDrawingLeavesNothing) {
  const auto run =
      poked("synthetic://walking?size=64x48&duration=1",
            {{"choreoscope: drawing", SIGINT}, {"again to leave nothing", SIGINT}}, {"--set", "plot.width_px=2400"});
  EXPECT_EQ(run.out, "");
  expect_old_results();
}

TEST_F(Interruption, OnceWhileDrawingWritesEverything) {
  poked("synthetic://walking?size=64x48&duration=1", {{"choreoscope: drawing", SIGINT}},
        {"--save", "masks", "--set", "plot.width_px=2400"});
  const Results r(old());
  EXPECT_EQ(r.n, 60u);
  EXPECT_EQ(r.summary["interrupted"], false) << "all frames are in it";
}

TEST_F(Interruption, WhileNothingComesFromAPipe) {
  const auto pipe = folder_ / "pipe.mkv";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  RunOptions options;
  int writer = -1;
  // Opens once the program reads at the other end, and says nothing.
  options.started = [&](int process) {
    writer = ::open(pipe.c_str(), O_WRONLY);
    ::kill(process, SIGINT);
  };
  const auto run = choreoscope({"analyze", pipe, "--out", old()}, options);
  ::close(writer);
  EXPECT_EQ(run.status, kKilled) << run.told();
  EXPECT_TRUE(run.err_lines("choreoscope: error: ").empty()) << run.told();
  expect_old_results();
}

TEST_F(Interruption, WhatIsIgnoredByNohupOrTheBackgroundStaysIgnored) {
  RunOptions options;
  options.pokes = {{"reading frames: 20 %", SIGHUP}};
  // exec keeps the process, so that the signal reaches the program.
  const auto run = run_program("/bin/sh",
                               {"-c", R"(trap '' HUP; exec "$0" analyze "$1" --out "$2")", program(),
                                "synthetic://walking?size=64x48&duration=10", old()},
                               options);
  EXPECT_EQ(run.poked, 1u) << run.told();
  EXPECT_EQ(run.status, 0) << run.told();
  EXPECT_EQ(Results(old()).n, 330u);
}

TEST_F(Interruption, WhileReadingASetOfPicturesLeavesNothing) {
  std::filesystem::create_directory(folder_ / "set");
  for (int k = 0; k < 24; ++k) write_png("set/" + std::to_string(k) + ".png", {320, 240}, std::uint64_t(k));
  for (const int signal : {SIGINT, SIGTERM}) {
    const auto run = poked(folder_ / "set?stills=1", {{"reading pictures", signal}}, {"--recognise", "semaphore"});
    EXPECT_THAT(run.err, HasSubstr("nothing was written"));
    EXPECT_EQ(run.out, "");
    expect_old_results();
  }
}

TEST_F(Interruption, WhileFilmingLeavesNoClip) {
  std::filesystem::create_directory(folder_ / "clips");
  RunOptions options;
  options.pokes = {{"filming", SIGINT}};
  const auto run = choreoscope({"synth", "walking?size=160x120&duration=30", "-o", folder_ / "clips/a.mkv"}, options);
  EXPECT_EQ(run.status, kKilled) << run.told();
  EXPECT_EQ(run.out, "");
  EXPECT_TRUE(files_in(folder_ / "clips").empty()) << ::testing::PrintToString(files_in(folder_ / "clips"));
}

// Somebody has the other end of standard error and does not read.
class UnreadInterruption : public Interruption {
 protected:
  static constexpr auto kBounded = std::chrono::seconds(30);  // Of a busy machine; it takes less than two.

  template <typename Condition>
  static bool becomes(const Condition& condition) {
    const auto deadline = std::chrono::steady_clock::now() + kBounded;
    while (!condition()) {
      if (std::chrono::steady_clock::now() > deadline) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return true;
  }

  // Sends the signals once frames are read, which a file tells whose name begins so, and reads what is said only when
  // the program has ended.
  Outcome interrupted(const std::vector<std::string>& arguments, const std::string& file,
                      const std::vector<int>& signals) {
    RunOptions options;
    options.full_err = true;
    options.started = [&](int process) {
      EXPECT_TRUE(becomes([&] { return has_bytes(file); })) << "it never came so far";
      for (const int signal : signals) ::kill(process, signal);
      const bool ended = ends_within(process, kBounded);
      EXPECT_TRUE(ended) << "only SIGKILL is left";
      if (!ended) ::kill(process, SIGKILL);
    };
    return choreoscope(arguments, options);
  }

  [[nodiscard]] bool has_bytes(const std::string& beginning) const {
    constexpr std::uintmax_t kHead = 500;  // Of a file without a frame, at the most.
    const auto names = files_in(folder_.path());
    return std::any_of(names.begin(), names.end(), [&](const std::string& name) {
      std::error_code gone;
      const auto bytes = std::filesystem::file_size(folder_ / name, gone);
      return name.starts_with(beginning) && !gone && bytes > kHead;
    });
  }
};

TEST_F(UnreadInterruption, OfALiveRunWritesItsResults) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const auto run = interrupted({"live", "synthetic://walking?size=64x48&fps=30&duration=60&empty=1", "--headless",
                                  "--background", "first:0.1s", "--out", old(), "--record", folder_ / "take.mkv"},
                                 "take.unfinished.mkv", {SIGUSR1, signal});
    EXPECT_EQ(run.status, kKilled) << run.told();
    const Results r(old());
    EXPECT_EQ(r.summary["interrupted"], true);
    EXPECT_GT(r.n, 0u);
    EXPECT_TRUE(std::filesystem::remove(folder_ / "take.mkv"));
  }
}

TEST_F(UnreadInterruption, OfAnAnalysisWritesWhatWasRead) {
  const auto run = interrupted({"analyze", kLong, "--out", old(), "--background", "first:0.1s", "--save", "masks"},
                               "old/.masks.npy", {SIGINT});
  EXPECT_EQ(run.status, kKilled) << run.told();
  expect_what_was_read(930);
}

TEST_F(UnreadInterruption, OfARecordingFinishesIt) {
  const auto run = interrupted({"record", kLong, "-o", folder_ / "take.mkv"}, "take.unfinished.mkv", {SIGTERM});
  EXPECT_EQ(run.status, kKilled) << run.told();
  EXPECT_TRUE(std::filesystem::exists(folder_ / "take.mkv"));
}

TEST_F(UnreadInterruption, TwiceLeavesNothing) {
  const auto run = interrupted({"analyze", kLong, "--out", old(), "--background", "first:0.1s", "--save", "masks"},
                               "old/.masks.npy", {SIGINT, SIGTERM});
  EXPECT_EQ(run.status, kKilled) << run.told();
  EXPECT_EQ(run.out, "");
  expect_old_results();
}

// What is said is read at last, in its order, and frames did not wait for that.
TEST_F(UnreadInterruption, IsNotNeededForARunToGoOn) {
  RunOptions options;
  options.full_err = true;
  std::filesystem::remove_all(old());
  options.started = [&](int) {
    EXPECT_TRUE(becomes([&] { return std::filesystem::exists(old() + "/summary.json"); })) << "it waits to be read";
  };
  const std::vector<std::string> arguments{
      "live", "synthetic://walking?size=64x48&fps=30&duration=1&empty=1", "--pace", "max", "--headless", "--out",
      old()};
  const auto unread = choreoscope(arguments, options);
  EXPECT_EQ(unread.status, 0) << unread.told();
  EXPECT_EQ(Results(old()).n, 60u);
  std::filesystem::remove_all(old());
  const auto read = choreoscope(arguments);
  EXPECT_EQ(unread.err_lines().size(), read.err_lines().size()) << unread.told() << read.told();
  EXPECT_EQ(unread.err_lines().front(), read.err_lines().front());
  EXPECT_EQ(unread.out, read.out);
}

}  // namespace
}  // namespace choreo::test
