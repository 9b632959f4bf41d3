// SPDX-License-Identifier: Apache-2.0
// The commands around analyze: synth, config, --help and --version.
#include <gmock/gmock.h>

#include "end_to_end/refusal_fixture.hpp"
#include "support/places.hpp"

namespace choreo::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class Commands : public RefusalTest {};

TEST_F(Commands, SynthWritesTheClipItsMasksAndItsTruth) {
  const auto run =
      choreoscope({"synth", "walking?size=160x120&fps=25&duration=1&seed=4", "-o", folder_ / "clips/a.mkv"});
  EXPECT_EQ(run.status, 0) << run.told();
  EXPECT_EQ(files_in(folder_ / "clips"), (std::set<std::string>{"a.mkv", "a.masks.mkv", "a.truth.json"}));
  const auto text = read_bytes(folder_ / "clips/a.truth.json");
  const auto truth = nlohmann::json::parse(text.begin(), text.end());
  EXPECT_EQ(truth["script"], "walking");
  EXPECT_EQ(truth["fps"], 25);
  ASSERT_EQ(truth["frames"].size(), 50u);  // One second of empty room before.
  EXPECT_EQ(truth["frames"][24]["body"], false);
  EXPECT_EQ(truth["frames"][25]["body"], true);
  EXPECT_NEAR(truth["frames"][25]["time_s"].get<double>(), 1.0, 1e-9);
  EXPECT_GT(truth["frames"][25]["joints"].size(), 15u);
  // The clip is what the URI would have shown.
  analyze(folder_ / "clips/a.mkv", folder_ / "file");
  analyze("synthetic://walking?size=160x120&fps=25&duration=1&seed=4", folder_ / "direct");
  EXPECT_TRUE(Results(folder_ / "file").z.data == Results(folder_ / "direct").z.data);
}

TEST_F(Commands, SynthGivesTheSameBytesForTheSameSeedAndOthersForAnother) {
  const std::string script = "palindrome?size=160x120&duration=1&seed=";
  for (const auto* ending : {".mkv", ".mp4"}) {
    for (const auto& [name, seed] : {std::pair{"one", "7"}, {"again", "7"}, {"other", "8"}}) {
      const auto run = choreoscope({"synth", script + seed, "-o", folder_ / name + ending});
      ASSERT_EQ(run.status, 0) << run.told();
    }
    const auto same = [&](const std::string& a, const std::string& b) {
      return read_bytes(folder_ / a) == read_bytes(folder_ / b);
    };
    EXPECT_TRUE(same(std::string("one") + ending, std::string("again") + ending));
    EXPECT_TRUE(same("one.masks.mkv", "again.masks.mkv"));
    EXPECT_TRUE(same("one.truth.json", "again.truth.json"));
    EXPECT_FALSE(same(std::string("one") + ending, std::string("other") + ending));
  }
}

TEST_F(Commands, SynthRefusesWhatItCannotFilm) {
  const auto refused_synth = [&](const std::string& script, const std::string& out) {
    std::filesystem::create_directories(folder_ / "clips");
    const auto run = choreoscope({"synth", script, "-o", out});
    EXPECT_TRUE(files_in(folder_ / "clips").empty()) << ::testing::PrintToString(files_in(folder_ / "clips"));
    return complaint_of(run, 2) + " | " + hint_of(run);
  };
  const auto clip = folder_ / "clips/a.mkv";
  EXPECT_THAT(refused_synth("wolking", clip), HasSubstr("did you mean \"walking\"?"));
  EXPECT_THAT(refused_synth("walking?nois=3", clip), HasSubstr("did you mean \"noise\"?"));
  EXPECT_THAT(refused_synth("walking?size=8x8", clip), HasSubstr("16x16"));
  EXPECT_THAT(refused_synth("walking?seed=-1", clip), HasSubstr("seed is \"-1\""));
  EXPECT_THAT(refused_synth("walking?duration=0.2", folder_ / "clips/a.avi"),
              AllOf(HasSubstr(".avi"), HasSubstr(".mkv")));
  EXPECT_THAT(refused_synth("walking?duration=0.2", "/proc/a.mkv"), HasSubstr("/proc"));
  write_bytes(folder_ / "file", std::string("precious"));
  EXPECT_THAT(refused_synth("walking?duration=0.2", folder_ / "file/a.mkv"), HasSubstr("is not a folder"));
  std::filesystem::create_directory(folder_ / "b.mkv");
  EXPECT_THAT(refused_synth("walking?duration=0.2", folder_ / "b.mkv"), HasSubstr("b.mkv"));
  EXPECT_THAT(refused_synth("walking?duration=0.2", ""), HasSubstr(".mkv"));
}

TEST_F(Commands, ConfigShowGoesThroughConfigCheckAndBackUnchanged) {
  const auto shown = choreoscope({"config", "show"});
  EXPECT_EQ(shown.status, 0);
  EXPECT_EQ(shown.err, "");
  write_bytes(folder_ / "all.toml", shown.out);
  const auto checked = choreoscope({"config", "check", folder_ / "all.toml"});
  EXPECT_EQ(checked.status, 0) << checked.told();
  const auto without_origins = [](std::string text) { return std::regex_replace(text, std::regex("  # .*"), ""); };
  const auto again = choreoscope({"config", "show", "--config", folder_ / "all.toml"});
  EXPECT_EQ(without_origins(again.out), without_origins(shown.out));
  EXPECT_THAT(shown.out, HasSubstr("rows = 480  # default"));
  EXPECT_THAT(again.out, HasSubstr("# " + folder_ / "all.toml:"));
}

TEST_F(Commands, ConfigShowTellsWhereEveryValueComesFrom) {
  write_bytes(folder_ / "my.toml", std::string("[mask]\nsteps = 3\nthreshold = 12\n"));
  const auto run = choreoscope({"config", "show", "--config", folder_ / "my.toml", "--set", "mask.threshold=18"});
  EXPECT_THAT(run.out, AllOf(HasSubstr("steps = 3  # " + folder_ / "my.toml:2\n"),
                             HasSubstr("threshold = 18  # --set\n"), HasSubstr("rows = 480  # default\n")));
}

TEST_F(Commands, ConfigCheckSaysEveryPresetOfTheProjectIsRight) {
  int count = 0;
  const auto presets = std::filesystem::path(project_file("config/presets"));
  for (const auto& entry : std::filesystem::directory_iterator(presets)) {
    if (entry.path().extension() != ".toml") continue;
    const auto run = choreoscope({"config", "check", entry.path().string()});
    EXPECT_EQ(run.status, 0) << run.told();
    ++count;
  }
  EXPECT_GE(count, 2);
}

TEST_F(Commands, APresetIsCalledByItsNameUnlessAFileHasIt) {
  const auto by_name = choreoscope({"config", "show", "--config", "stage"});
  EXPECT_EQ(by_name.status, 0) << by_name.told();
  EXPECT_THAT(by_name.out, HasSubstr("presets/stage.toml:"));
  write_bytes(folder_ / "stage", std::string("[mask]\nsteps = 7\n"));
  RunOptions there;
  there.folder = folder_.path();
  EXPECT_THAT(choreoscope({"config", "show", "--config", "stage"}, there).out, HasSubstr("steps = 7  # stage:2"));
  const auto neither = choreoscope({"config", "show", "--config", "stagger"});
  EXPECT_THAT(complaint_of(neither, 2), HasSubstr("stagger"));
  EXPECT_THAT(hint_of(neither), HasSubstr("presets: archive, default, flags, kinect, rehearsal-room, stage, webcam"));
}

TEST_F(Commands, VersionIsOneLineOnStandardOutput) {
  const auto run = choreoscope({"--version"});
  EXPECT_EQ(run.status, 0);
  EXPECT_EQ(run.err, "");
  EXPECT_TRUE(std::regex_match(run.out, std::regex("choreoscope [0-9]+\\.[0-9]+\\.[0-9]+\n"))) << run.out;
}

TEST_F(Commands, HelpOfEveryCommandReadsLikeAManualPage) {
  const std::vector<std::vector<std::string>> commands{
      {}, {"analyze"}, {"synth"}, {"config"}, {"config", "show"}, {"config", "check"}, {"calibrate"}};
  for (auto words : commands) {
    std::string name = "choreoscope";
    for (const auto& word : words) name += " " + word;
    words.emplace_back("--help");
    const auto run = choreoscope(words);
    EXPECT_EQ(run.status, 0) << run.told();
    EXPECT_EQ(run.err, "");
    EXPECT_THAT(run.out, HasSubstr("Usage: " + name)) << name;
    EXPECT_THAT(run.out, ::testing::ContainsRegex("\n  " + name + " [^[]")) << name << " shows no example";
    for (std::size_t begin = 0; begin < run.out.size();) {
      const auto end = run.out.find('\n', begin);
      EXPECT_LE(end - begin, 130u) << name << ": " << run.out.substr(begin, end - begin);
      begin = end + 1;
    }
  }
  const auto analyze = choreoscope({"analyze", "--help"}).out;
  // Units, ranges and defaults.
  for (const auto* told : {"1 to 1000000, default 1", "0 to 1024, default 0", "seconds, half open", "(default)",
                           "Exit status", "masks.npy"}) {
    EXPECT_THAT(analyze, HasSubstr(told));
  }
  const auto synth = choreoscope({"synth", "--help"}).out;
  for (const auto* told :
       {"jumping-jacks", "semaphore", "size=", "fps=", "seed=", "noise=", "grey levels", "default"}) {
    EXPECT_THAT(synth, HasSubstr(told));
  }
}

TEST_F(Commands, WithoutArgumentsItIsRefusedWithAHint) {
  const auto run = choreoscope({});
  EXPECT_NE(complaint_of(run, 2), "");
  EXPECT_THAT(hint_of(run), AllOf(HasSubstr("analyze"), HasSubstr("synth"), HasSubstr("config"), HasSubstr("--help")));
}

}  // namespace
}  // namespace choreo::test
