// SPDX-License-Identifier: Apache-2.0
// choreoscope calibrate: the bounds of a stretch as a file that other commands take, and what is no stretch.
#include <csignal>

#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

#include "body/particle_calibration.hpp"
#include "end_to_end/choreoscope_run.hpp"

namespace choreo::test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

class Calibrate : public ::testing::Test {
 protected:
  // Both arms to the sides, up, and one of each.
  static constexpr auto kStretch = "synthetic://semaphore?text=RUD&fps=10&seed=5&skin=light&size=320x240";

  [[nodiscard]] std::string file() const { return folder_ / "bounds.toml"; }

  Outcome calibrate(const std::string& source, const std::vector<std::string>& more = {},
                    const RunOptions& options = {}) {
    std::vector<std::string> arguments{"calibrate", source, "-o", file()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return choreoscope(arguments, options);
  }

  // What an earlier calibration wrote stays, and nothing comes beside it.
  std::string refused(const std::string& source, const std::vector<std::string>& more = {}) {
    write_bytes(file(), std::string("# older\n"));
    const auto complaint = complaint_of(calibrate(source, more), 2);
    EXPECT_EQ(read_bytes(file()).size(), 8U);
    return complaint;
  }

  TempFolder folder_;
};

// The value that a line such as "particles.c_max = 0.2" says.
double said(const std::string& text, const std::string& name) {
  const auto at = text.find(name + " = ");
  if (at != std::string::npos) return std::stod(text.substr(at + name.size() + 3));
  ADD_FAILURE() << "no " << name << " in " << text;
  return 0;
}

TEST_F(Calibrate, AStretchBecomesSettingsThatOtherCommandsTake) {
  const auto run = calibrate(kStretch);
  ASSERT_EQ(run.status, 0) << run.told();
  EXPECT_EQ(files_in(folder_.path()), std::set<std::string>{"bounds.toml"});
  EXPECT_THAT(run.err_lines("choreoscope: warning: "), Not(Contains(HasSubstr("stretched"))));
  const body::ParticleBounds vitruvian;
  // The performer's proportions are a man's or woman's, not quite Vitruvius'.
  EXPECT_NEAR(said(run.out, "particles.alpha_max"), vitruvian.alpha_max, 0.2 * vitruvian.alpha_max);
  EXPECT_NEAR(said(run.out, "particles.eta_max"), vitruvian.eta_max, 0.4 * vitruvian.eta_max);
  EXPECT_NEAR(said(run.out, "particles.c_max"), vitruvian.c_max, 0.5 * vitruvian.c_max);

  const auto show = choreoscope({"config", "show", "--config", "stage", "--config", file()});
  ASSERT_EQ(show.status, 0) << show.told();
  const auto particles = show.out.substr(show.out.find("[particles]"));
  for (const auto* name : {"alpha_max", "c_max", "eta_max"}) {
    EXPECT_EQ(said(particles, name), said(run.out, std::string("particles.") + name)) << name;
  }
  EXPECT_THAT(show.out, AllOf(HasSubstr("bounds.toml:"), HasSubstr("stage.toml:"))) << "both files count";
}

TEST_F(Calibrate, ASpanWithoutTheStretchIsNone) {
  EXPECT_THAT(refused(kStretch, {"--span", "0:4"}), HasSubstr("too few"));
  // H: one arm aside, the other before the body; between letters both hang.
  EXPECT_THAT(refused("synthetic://semaphore?text=HH&fps=10&seed=5&skin=light&size=320x240"),
              HasSubstr("the arms were not stretched: half their distance came to 1."));
  EXPECT_THAT(refused(kStretch, {"--span", "500:600"}), HasSubstr("no frame"));
}

// A: one arm hangs, the other slants a little.
TEST_F(Calibrate, HalfAStretchIsWarnedOf) {
  const auto run = calibrate("synthetic://semaphore?text=AA&fps=10&seed=5&skin=light&size=320x240");
  ASSERT_EQ(run.status, 0) << run.told();
  EXPECT_THAT(run.err_lines("choreoscope: warning: "), Contains(HasSubstr("were both stretched to the sides?")));
}

TEST_F(Calibrate, WhatShowsNoPerformerIsRefused) {
  EXPECT_THAT(refused("synthetic://walking?size=160x120&fps=10&duration=2&seed=4"), HasSubstr("no face was ever seen"));
  EXPECT_THAT(refused("synthetic://walking?size=160x120&fps=10&duration=0.1&empty=2", {"--span", "0:1.5"}),
              HasSubstr("no body was ever seen"));
  EXPECT_THAT(refused(kStretch, {"--set", "arms.largest_arm=5", "--set", "arms.least_arm=5"}),
              HasSubstr("two arms were never seen"));
  const auto grey = folder_ / "grey";
  std::filesystem::create_directory(grey);
  for (int k = 0; k < 12; ++k) {
    cv::imwrite(grey + "/f" + std::to_string(100 + k) + ".png", cv::Mat(120, 160, CV_8UC3, cv::Scalar::all(90 + k)));
  }
  EXPECT_THAT(refused(grey), HasSubstr("no colour"));
}

TEST_F(Calibrate, FoldersOfTheFileAreMadeAndAnyEndingIsTakenByConfig) {
  const auto path = folder_ / "new" + "/deep/bounds.txt";
  const auto run = choreoscope({"calibrate", kStretch, "-o", path});
  ASSERT_EQ(run.status, 0) << run.told();
  const auto show = choreoscope({"config", "show", "--config", path});
  EXPECT_EQ(said(show.out, "alpha_max"), said(run.out, "particles.alpha_max"));
}

TEST_F(Calibrate, PlacesThatCannotBeWrittenToAreRefusedBeforeTheRun) {
  EXPECT_THAT(complaint_of(choreoscope({"calibrate", kStretch, "-o", folder_.path() + "/"}), 2),
              HasSubstr("names no file"));
  std::filesystem::create_directory(folder_ / "taken.toml");
  EXPECT_THAT(complaint_of(choreoscope({"calibrate", kStretch, "-o", folder_ / "taken.toml"}), 2),
              HasSubstr("taken.toml"));
  EXPECT_THAT(choreoscope({"calibrate", kStretch}).err, HasSubstr("--out"));
}

TEST_F(Calibrate, AnInterruptionBeforeTheStretchLeavesNothing) {
  RunOptions options;
  options.pokes = {{"learning the background", SIGINT}};
  const auto run = calibrate("synthetic://semaphore?text=RUDRUDRUD&fps=30&seed=5&skin=light", {}, options);
  EXPECT_EQ(run.status, 130) << run.told();
  EXPECT_TRUE(files_in(folder_.path()).empty());
}

TEST_F(Calibrate, HandsAloneAreTooShortForAnArmsCovarianceWhichIsSaid) {
  const auto run = calibrate(std::string(kStretch) + "&sleeves=long");
  ASSERT_EQ(run.status, 0) << run.told();
  EXPECT_THAT(run.err_lines("choreoscope: warning: "), Contains(HasSubstr("hands or flags alone")));
}

}  // namespace
}  // namespace choreo::test
