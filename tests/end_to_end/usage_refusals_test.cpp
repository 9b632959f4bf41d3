// SPDX-License-Identifier: Apache-2.0
// Command lines and configurations that are wrong: exit status 2, where it is wrong and what would be right.
#include <sys/stat.h>
#include <unistd.h>

#include <gmock/gmock.h>

#include "end_to_end/refusal_fixture.hpp"

namespace choreo::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class UsageRefusal : public RefusalTest {
 protected:
  std::string refused_config(const std::string& text) {
    write_bytes(folder_ / "my.toml", text);
    const auto complaint = refused(kQuick, {"--config", folder_ / "my.toml"});
    // `config check` says the same.
    EXPECT_EQ(complaint_of(choreoscope({"config", "check", folder_ / "my.toml"}), 2), complaint);
    return complaint;
  }
  [[nodiscard]] std::string at(const std::string& line_column) const { return folder_ / "my.toml" + ":" + line_column; }
};

TEST_F(UsageRefusal, AnUnknownSettingIsFoundByLineAndColumnWithTheNearestKey) {
  EXPECT_THAT(refused_config("# mine\n[mask]\nsteps = 2\n  treshold = 12\n"),
              AllOf(StartsWith(at("4:3: ")), HasSubstr("mask.treshold")));
  EXPECT_EQ(hint(), "did you mean \"mask.threshold\"?");
  EXPECT_THAT(refused_config("[masks]\nthreshold = 12\n"), StartsWith(at("2:1: ")));
  EXPECT_EQ(hint(), "did you mean \"mask.threshold\"?");
  EXPECT_THAT(refused_config("threshold = 12\n"), StartsWith(at("1:1: ")));
  EXPECT_EQ(hint(), "did you mean \"mask.threshold\"?");
}

TEST_F(UsageRefusal, AValueOfTheWrongTypeOrOutOfRangeNamesItsRange) {
  EXPECT_THAT(refused_config("[mask]\nthreshold = \"high\"\n"), AllOf(StartsWith(at("2:13: ")), HasSubstr("\"high\"")));
  EXPECT_THAT(hint(), HasSubstr("at most 255"));
  EXPECT_THAT(refused_config("[mask]\nsteps = 2.5\n"), AllOf(StartsWith(at("2:9: ")), HasSubstr("2.5")));
  EXPECT_THAT(refused_config("[mask]\n\nsteps = 33\n"), AllOf(StartsWith(at("3:9: ")), HasSubstr("33")));
  EXPECT_THAT(hint(), HasSubstr("from 0 to 32"));
  EXPECT_THAT(refused_config("[mask]\nlargest_only = 1\n"), StartsWith(at("2:16: ")));
  EXPECT_THAT(refused_config("[mask]\nroi = [0.5, 0, 0.5, 1]\n"), StartsWith(at("2:7: ")));
  EXPECT_THAT(refused_config("[motion]\nwindow_s = nan\n"), StartsWith(at("2:12: ")));
}

TEST_F(UsageRefusal, AFileThatIsNoTomlIsFoundByLineAndColumn) {
  EXPECT_THAT(refused_config("[mask]\nsteps 2\n"), StartsWith(at("2:")));
  EXPECT_THAT(refused_config("[mask]\nsteps = 2\nsteps = 3\n"), StartsWith(at("3:")));
}

TEST_F(UsageRefusal, AConfigurationFileThatCannotBeRead) {
  EXPECT_THAT(refused(kQuick, {"--config", folder_ / "none.toml"}), HasSubstr("none.toml"));
  EXPECT_THAT(refused(kQuick, {"--config", folder_.path()}), HasSubstr("folder"));
}

TEST_F(UsageRefusal, SettingsOnTheCommandLine) {
  EXPECT_THAT(refused(kQuick, {"--set", "mask.treshold=12"}), HasSubstr("mask.treshold"));
  EXPECT_EQ(hint(), "did you mean \"mask.threshold\"?");
  EXPECT_THAT(refused(kQuick, {"--set", "mask.threshold=high"}), AllOf(HasSubstr("--set"), HasSubstr("\"high\"")));
  EXPECT_THAT(refused(kQuick, {"--set", "mask.threshold=0"}), HasSubstr("mask.threshold"));
  EXPECT_THAT(refused(kQuick, {"--set", "working.rows=-1"}), HasSubstr("working.rows"));
  EXPECT_THAT(refused(kQuick, {"--set", "plot.page=grey"}), HasSubstr("plot.page"));
  EXPECT_THAT(hint(), AllOf(HasSubstr("\"light\""), HasSubstr("\"dark\"")));
  EXPECT_THAT(refused(kQuick, {"--set", "mask.steps"}), HasSubstr("key=value"));
}

TEST_F(UsageRefusal, NumbersOfTheCommandLineOutOfRange) {
  for (const auto* every : {"0", "-1", "1000001"}) {
    EXPECT_THAT(refused(kQuick, {"--every", every}), AllOf(HasSubstr("--every"), HasSubstr(every)));
    EXPECT_THAT(hint(), HasSubstr("from 1 to 1000000"));
  }
  for (const auto* threads : {"-1", "1025"}) {
    EXPECT_THAT(refused(kQuick, {"--threads", threads}), AllOf(HasSubstr("--threads"), HasSubstr(threads)));
    EXPECT_THAT(hint(), HasSubstr("from 0 (all) to 1024"));
  }
  for (const auto* no_number : {"two", "2.5", "", "99999999999999999999"}) {
    EXPECT_THAT(refused(kQuick, {"--every", no_number}), HasSubstr("--every"));
    EXPECT_THAT(refused(kQuick, {"--threads", no_number}), HasSubstr("--threads"));
  }
}

TEST_F(UsageRefusal, SpansThatAreNoneOrLieOutsideTheClip) {
  for (const auto* span : {"3", "a:b", "2:1", "1:1", "-1:2", "0f:3f", "3f:2f", "1f:2", ":", "1:2:3", ""}) {
    const auto complaint = refused(kQuick, {"--span", span});
    EXPECT_THAT(complaint, HasSubstr("span")) << span;
    EXPECT_THAT(hint(), HasSubstr("1f:468f")) << span;
  }
  EXPECT_THAT(refused(kQuick, {"--span", "10:20"}), AllOf(HasSubstr("10:20"), HasSubstr("6 frames")));
  EXPECT_THAT(refused(kQuick, {"--span", "7f:"}), AllOf(HasSubstr("7f:"), HasSubstr("6 frames")));
}

TEST_F(UsageRefusal, BackgroundsThatAreNone) {
  EXPECT_THAT(refused(kQuick, {"--background", "first:0s"}), HasSubstr("first:0s"));
  EXPECT_THAT(refused(kQuick, {"--background", "first:soon"}), HasSubstr("soon"));
  EXPECT_THAT(refused(kQuick, {"--background", ""}), HasSubstr("background"));
}

TEST_F(UsageRefusal, AnUnknownInstructionSetListsTheKnownOnes) {
  RunOptions options;
  options.environment = {{"CHOREO_FORCE_ISA", "MMX"}};
  EXPECT_THAT(refused(kQuick, {}, 2, options), HasSubstr("MMX"));
  EXPECT_THAT(last_.err, HasSubstr("scalar"));
}

TEST_F(UsageRefusal, AFileWhereTheOutputFolderShouldBe) {
  write_bytes(folder_ / "taken", std::string("precious"));
  for (const auto& out : {folder_ / "taken", folder_ / "taken" + "/deeper"}) {
    EXPECT_THAT(complaint_of(choreoscope({"analyze", kQuick, "--out", out}), 2), HasSubstr("taken\" is not a folder"));
  }
  const auto bytes = read_bytes(folder_ / "taken");
  EXPECT_EQ(std::string(bytes.begin(), bytes.end()), "precious");
}

TEST_F(UsageRefusal, AFolderWhereAResultShouldBeIsFoundBeforeTheWorkBegins) {
  std::filesystem::create_directories(folder_ / "out/summary.json");
  const auto run = choreoscope({"analyze", kQuick, "--out", folder_ / "out"});
  EXPECT_THAT(complaint_of(run, 2), HasSubstr("summary.json"));
  EXPECT_TRUE(run.err_lines("choreoscope: reading").empty()) << run.told();
  EXPECT_EQ(files_in(folder_ / "out"), std::set<std::string>{"summary.json"});
}

TEST_F(UsageRefusal, APlaceThatMayNotBeWrittenTo) {
  // Nobody makes folders in /proc, not even root.
  EXPECT_THAT(complaint_of(choreoscope({"analyze", kQuick, "--out", "/proc/choreoscope-out"}), 2),
              HasSubstr("/proc/choreoscope-out"));
  EXPECT_THAT(complaint_of(choreoscope({"analyze", kQuick, "--out", "/proc"}), 2), HasSubstr("/proc"));
  std::filesystem::create_directory(folder_ / "locked");
  ASSERT_EQ(::chmod((folder_ / "locked").c_str(), 0500), 0);
  // Root may write everywhere, unless this is taken away.
  std::vector<std::string> words{"/usr/bin/setpriv", "--bounding-set", "-dac_override"};
  if (::geteuid() != 0) words.clear();
  for (const auto& word :
       {program(), std::string("analyze"), std::string(kQuick), std::string("--out"), folder_ / "locked"}) {
    words.push_back(word);
  }
  const auto locked_out = run_program(words.front(), {words.begin() + 1, words.end()});
  EXPECT_THAT(complaint_of(locked_out, 2), HasSubstr("locked"));
  EXPECT_TRUE(files_in(folder_ / "locked").empty());
}

TEST_F(UsageRefusal, AnUnknownCommandIsAnsweredWithTheNearest) {
  const auto run = choreoscope({"analyse", kQuick, "--out", folder_ / "new"});
  EXPECT_THAT(complaint_of(run, 2), HasSubstr("analyse"));
  EXPECT_EQ(hint_of(run), "did you mean \"analyze\"?");
  const auto nested = choreoscope({"config", "shwo"});
  EXPECT_THAT(complaint_of(nested, 2), HasSubstr("shwo"));
  EXPECT_THAT(hint_of(nested), HasSubstr("show"));
}

TEST_F(UsageRefusal, WhatIsMissingIsNamed) {
  EXPECT_THAT(complaint_of(choreoscope({"analyze", "--out", folder_ / "new"}), 2), HasSubstr("SOURCE"));
  EXPECT_THAT(complaint_of(choreoscope({"analyze", kQuick}), 2), HasSubstr("--out"));
  EXPECT_THAT(complaint_of(choreoscope({"synth", "walking"}), 2), HasSubstr("--out"));
  EXPECT_THAT(complaint_of(choreoscope({"analyze", kQuick, "--out", ""}), 2), HasSubstr("--out"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "new"));
}

TEST_F(UsageRefusal, AnUnknownOptionIsAnsweredWithTheNearest) {
  EXPECT_THAT(refused(kQuick, {"--evry", "2"}), HasSubstr("--evry"));
  EXPECT_THAT(hint(), HasSubstr("--every"));
  EXPECT_THAT(refused(kQuick, {"--save", "mask"}), AllOf(HasSubstr("--save"), HasSubstr("masks")));
}

}  // namespace
}  // namespace choreo::test
