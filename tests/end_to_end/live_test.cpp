// SPDX-License-Identifier: Apache-2.0
// Live runs of the built program: the same values as the batch, every drop counted, memory that stays, endings.
#include <csignal>
#include <regex>
#include <thread>

#include <gmock/gmock.h>

#include "end_to_end/refusal_fixture.hpp"
#include "support/eventually.hpp"
#include "support/places.hpp"
#include "support/shared_data.hpp"

namespace choreo::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::SizeIs;

class Live : public RefusalTest {
 protected:
  static constexpr auto kClip = "synthetic://walking?size=160x120&fps=15&duration=6&seed=4&tail=1";
  // Where the room is empty long enough for the median of the first two seconds.
  static constexpr auto kEmptyFirst = "synthetic://jumping-jacks?size=160x120&fps=30&duration=20&empty=3";

  [[nodiscard]] std::string out() const { return folder_ / "live"; }

  Outcome live(const std::string& source, std::vector<std::string> more, int status = 0,
               const RunOptions& options = {}) {
    std::vector<std::string> arguments{"live", source, "--headless"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    auto run = choreoscope(arguments, options);
    EXPECT_EQ(run.status, status) << run.told();
    return run;
  }

  // Asks for the latencies until standard error has what is waited for, then interrupts.
  Outcome live_until(const std::string& told, const std::string& source, const std::vector<std::string>& more) {
    const auto err = folder_ / "err";
    const auto has = [&err](const std::string& what) {
      const auto bytes = std::filesystem::exists(err) ? read_bytes(err) : Bytes();
      return std::regex_search(std::string(bytes.begin(), bytes.end()), std::regex(what));
    };
    RunOptions options;
    options.started = [&](int process) {
      const auto over = [process] { return ends_within(process, std::chrono::seconds(0)); };
      const auto ready = [&] { return has("learning the background"); };  // For signals.
      EXPECT_TRUE(eventually([&] { return ready() || over(); }) && !over());
      EXPECT_TRUE(eventually([&] {
                    std::this_thread::sleep_for(std::chrono::milliseconds(100));
                    if (!over()) ::kill(process, SIGUSR1);
                    return has(told) || over();
                  }) &&
                  !over());
      if (!over()) ::kill(process, SIGINT);
    };
    std::vector<std::string> arguments{
        "-c", R"(err=$1; shift; exec "$@" 2>"$err")", "sh", err, program(), "live", source, "--headless"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    auto run = run_program("/bin/sh", arguments, options);
    const auto bytes = read_bytes(err);
    run.err.assign(bytes.begin(), bytes.end());
    EXPECT_EQ(run.status, 130) << run.told();
    return run;
  }

  void expect_same_files(const std::string& a, const std::string& b) {
    for (const auto* name : {"z.npy", "zstar.npy", "times.npy", "frames.csv", "plot.png", "triangle.png"}) {
      EXPECT_TRUE(read_bytes(a + "/" + name) == read_bytes(b + "/" + name)) << name;
    }
  }
};

TEST_F(Live, EqualsTheBatchToTheLastBit) {
  live(kClip, {"--pace", "max", "--out", out()});
  analyze(kClip, folder_ / "batch", {"--set", "working.rows=120", "--background", "first:2s"});
  expect_same_files(out(), folder_ / "batch");
}

TEST_F(Live, EqualsTheBatchWithAnySettingsAndThreads) {
  const std::vector<std::string> settings{"--set", "working.rows=80", "--background", "auto", "--every",
                                          "2",     "--span",          "1:5"};
  auto more = settings;
  more.insert(more.end(), {"--pace", "max", "--threads", "1", "--out", out()});
  live(kClip, more);
  analyze(kClip, folder_ / "batch", settings);
  expect_same_files(out(), folder_ / "batch");
}

TEST_F(Live, KeepsTheLastFramesOfTheHistoryAndTheirValues) {
  live(kClip, {"--pace", "max", "--history", "2s", "--out", out()});
  analyze(kClip, folder_ / "batch", {"--set", "working.rows=120", "--background", "first:2s"});
  const Results last(out());
  const Results all(folder_ / "batch");
  ASSERT_EQ(last.n, 30u) << "2 s of 15 frames a second";
  const auto begin = all.n - last.n;
  for (std::size_t i = 0; i < last.n; ++i) {
    EXPECT_EQ(last.time_s[i], all.time_s[begin + i]);
    for (std::size_t j = 0; j < last.n; ++j) {
      const bool gap = std::isnan(all.Z(begin + i, begin + j));
      ASSERT_TRUE(gap ? std::isnan(last.Z(i, j)) : last.Z(i, j) == all.Z(begin + i, begin + j)) << i << ", " << j;
      ASSERT_TRUE(gap ? std::isnan(last.Zstar(i, j)) : last.Zstar(i, j) == all.Zstar(begin + i, begin + j));
    }
  }
  const auto& told = last.summary["live"];
  EXPECT_EQ(told["capacity_rows"], 30);
  EXPECT_EQ(told["rows"], 30);
  EXPECT_EQ(told["history_s"], 2.0);
  EXPECT_GT(told["bytes_per_row"], 160 * 120 / 8);
  EXPECT_GE(told["history_bytes"], 30 * told["bytes_per_row"].get<int>());
  EXPECT_GT(last.summary["timings"]["row_ms_ring_full"]["max"], 0);
}

TEST_F(Live, AtItsOwnPaceNothingIsLostUncounted) {
  const auto run = live("synthetic://walking?size=64x48&fps=30&duration=2&empty=2", {"--pace", "live", "--out", out()});
  const Results r(out());
  const auto& timings = r.summary["timings"];
  EXPECT_EQ(r.n + timings["dropped"].get<std::size_t>(), 120u);
  EXPECT_GE(timings["frames_s"], 3.9) << "four seconds of video take four seconds";
  for (const auto* key : {"p50", "p99", "p99.9", "max"}) {
    EXPECT_GE(timings["latency_ms"][key], 0) << key;
    EXPECT_GE(timings["stages"][2]["latency_ms"][key], 0) << key;
  }
  EXPECT_THAT(run.err, AllOf(HasSubstr("p99.9"), HasSubstr("end to end"), HasSubstr("dropped"), HasSubstr("bytes")));
}

TEST_F(Live, ReplayTakesItsTimeAndLosesNothing) {
  live("synthetic://walking?size=64x48&fps=30&duration=1&empty=2", {"--pace", "replay", "--out", out()});
  const Results r(out());
  EXPECT_EQ(r.n, 90u);
  EXPECT_GE(r.summary["timings"]["frames_s"], 2.9);
  EXPECT_EQ(r.summary["timings"]["dropped"], 0);
}

// Its frames are there at once, and would all but a few be overtaken.
TEST_F(Live, APipeIsPlayedAtItsOwnTime) {
  const auto clip = folder_ / "clip.mkv";
  ASSERT_EQ(choreoscope({"synth", "walking?size=64x48&fps=30&duration=1&empty=0", "-o", clip}).status, 0);
  for (const std::string pace : {"live", "replay"}) {
    const auto pipe = folder_ / ("pipe-" + pace);
    const auto run = run_program(
        "/bin/sh", {"-c",
                    R"(mkfifo "$2"; cat "$1" > "$2" & exec "$0" live "$2" --headless --pace "$3" --out "$4")"
                    " --background first:0.2s",
                    program(), clip, pipe, pace, out()});
    ASSERT_EQ(run.status, 0) << run.told();
    const Results r(out());
    const auto& timings = r.summary["timings"];
    EXPECT_EQ(r.n + timings["dropped"].get<std::size_t>(), 30u) << pace;
    EXPECT_GE(timings["frames_s"], 0.9) << pace;
    EXPECT_TRUE(pace == "live" || r.n == 30u) << r.n;
  }
}

// The ring is as long as thirty frames a second take; a rate of 1000,
// Matroska's clock, took 600,000 rows.
TEST_F(Live, ABrowsersRecordingDeclaresNoRate) {
  const auto clip = shared_data("cases/chrome.webm");
  if (clip.empty()) GTEST_SKIP() << "the shared recordings are not here; set CHOREO_SHARED_DATA";
  live(clip, {"--pace", "max", "--background", "first:0.2s", "--out", out()});
  EXPECT_EQ(Results(out()).summary["live"]["capacity_rows"], 18000);
}

TEST_F(Live, WithoutOutNothingIsWritten) {
  RunOptions there;
  there.folder = folder_.path();
  const auto before = files_in(folder_.path());
  const auto run = live(kClip, {"--pace", "max"}, 0, there);
  EXPECT_EQ(run.out, "120 frames, 90 with a body\n");
  EXPECT_EQ(files_in(folder_.path()), before);
}

TEST_F(Live, CtrlCWritesWhatIsInTheHistory) {
  const auto run = live_until("[1-9][0-9]* frames, ", kEmptyFirst, {"--pace", "live", "--out", out()});
  EXPECT_THAT(run.err_lines("choreoscope: warning: interrupted"), SizeIs(1));
  const Results r(out());
  EXPECT_GT(r.n, 0u);
  EXPECT_LT(r.n, 600u);
  EXPECT_EQ(r.summary["interrupted"], true);
}

TEST_F(Live, ASignalAsksForTheLatencies) {
  const auto run =
      live_until("row, full", "synthetic://jumping-jacks?size=160x120&fps=30&duration=60&empty=1", {"--history", "1s"});
  EXPECT_THAT(run.err_lines("end to end"), SizeIs(testing::Ge(2))) << "for the signals, and at the end";
  EXPECT_THAT(run.err_lines("compare "), SizeIs(testing::Ge(2))) << "and so are the stages";
  EXPECT_THAT(run.err, HasSubstr("row, full"));
}

TEST_F(Live, WithoutADisplayItSaysSoAndGoesOn) {
  const auto run = run_program(
      "/bin/sh",
      {"-c", R"(unset DISPLAY WAYLAND_DISPLAY SDL_VIDEODRIVER; exec "$0" live "$1" --pace max)", program(), kClip});
  EXPECT_EQ(run.status, 0) << run.told();
  EXPECT_THAT(run.err_lines("choreoscope: warning: there is no display"), SizeIs(1));
}

TEST_F(Live, InAWindowTheResultsAreTheSame) {
  RunOptions options;
  options.environment = {{"SDL_VIDEODRIVER", "dummy"}};
  const auto run = choreoscope({"live", kClip, "--pace", "max", "--out", out()}, options);
  EXPECT_EQ(run.status, 0) << run.told();
  live(kClip, {"--pace", "max", "--out", folder_ / "headless"});
  expect_same_files(out(), folder_ / "headless");
}

TEST_F(Live, AFailureMidwayIsToldOfAndWhatCameBeforeIsWritten) {
  std::filesystem::create_directory(folder_ / "pictures");
  for (int i = 0; i < 20; ++i) write_png("pictures/" + std::to_string(100 + i) + ".png", {64, 48});
  write_png("pictures/115.png", {64, 50});
  const auto run = live(folder_ / "pictures", {"--pace", "max", "--background", "first:0.2s", "--out", out()}, 1);
  EXPECT_THAT(run.err_lines("choreoscope: error: "), SizeIs(1));
  EXPECT_EQ(Results(out()).n, 15u);
}

TEST_F(Live, RefusesWhatMakesNoSense) {
  const auto refuse = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"live", kQuick, "--headless", "--out", old()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto run = choreoscope(arguments);
    const auto complaint = complaint_of(run, 2);
    expect_old_results();
    return complaint + " " + hint_of(run);
  };
  EXPECT_THAT(refuse({"--pace", "slow"}), AllOf(HasSubstr("slow"), HasSubstr("live, replay, max")));
  EXPECT_THAT(refuse({"--history", "0s"}), HasSubstr("1s to 24h"));
  EXPECT_THAT(refuse({"--history", "25h"}), HasSubstr("1s to 24h"));
  EXPECT_THAT(refuse({"--history", "long"}), HasSubstr("--history"));
  EXPECT_THAT(refuse({"--span", "100:200"}), HasSubstr("no frame"));
}

TEST_F(Live, WithoutFilesItSaysAllTheSameWhatIsToBeKnown) {
  const auto run = live("synthetic://jumping-jacks?size=160x120&fps=15&duration=4&empty=0", {"--pace", "max"});
  EXPECT_THAT(run.err, HasSubstr("the background is uncertain"));
  EXPECT_EQ(run.out, "60 frames, 60 with a body\n");
}

TEST_F(Live, OptionsThatCannotMeanAnythingAreRefused) {
  EXPECT_THAT(complaint_of(choreoscope({"live", kQuick, "--headless", "--out", ""}), 2), HasSubstr("--out: is empty"));
  EXPECT_THAT(complaint_of(choreoscope({"live", kQuick, "--headless", "--full-screen"}), 2),
              HasSubstr("--full-screen"));
}

TEST_F(Live, AHistoryThatExceedsTheMemoryIsRefusedBeforeTheRun) {
  // 2.6 million rows of 264 kB.
  const auto run = choreoscope({"live", "synthetic://walking?size=1920x1080&fps=30&duration=1", "--headless",
                                "--history", "24h", "--set", "working.rows=0", "--out", old()});
  EXPECT_THAT(complaint_of(run, 2), AllOf(HasSubstr("--history"), HasSubstr("GB of memory")));
  EXPECT_THAT(hint_of(run), HasSubstr("shorten --history"));
  expect_old_results();
}

}  // namespace
}  // namespace choreo::test
