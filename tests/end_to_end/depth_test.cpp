// SPDX-License-Identifier: Apache-2.0
// segmentation = depth or both: what is written and told, that live equals the batch, what is refused.
#include <gmock/gmock.h>

#include "end_to_end/choreoscope_run.hpp"

namespace choreo::test {
namespace {

using ::testing::HasSubstr;

std::vector<std::string> by(const std::string& segmentation, std::vector<std::string> more = {}) {
  more.insert(more.end(), {"--set", "segmentation=" + segmentation});
  return more;
}

TEST(Depth, TheSummarySaysWhichSegmentationWasUsedAndWhatWasLearned) {
  const TempFolder folder;
  const std::string source = "synthetic://jumping-jacks?size=160x120&fps=10&duration=2&depth=1";
  analyze(source, folder / "colour");
  const auto colour = Results(folder / "colour").summary;
  EXPECT_EQ(colour["segmentation"], "auto");
  EXPECT_FALSE(colour.contains("depth"));
  EXPECT_TRUE(colour["threshold_grey_levels"].is_number());
  analyze(source, folder / "depth", by("depth"));
  const auto depth = Results(folder / "depth").summary;
  EXPECT_EQ(depth["segmentation"], "depth");
  EXPECT_TRUE(depth["threshold_grey_levels"].is_null());
  EXPECT_GT(depth["depth"]["share_of_room_known"], 0.99);
  EXPECT_EQ(depth["depth"]["share_of_room_inferred"], 0.0);
  EXPECT_NEAR(depth["depth"]["noise_mm_at_2_m"].get<double>(), 3.0, 1.0);
  analyze(source, folder / "both", by("both"));
  const auto both = Results(folder / "both").summary;
  EXPECT_EQ(both["segmentation"], "both");
  EXPECT_TRUE(both["threshold_grey_levels"].is_number());
  EXPECT_EQ(both["warnings"], nlohmann::json::array());
}

TEST(Depth, LiveGivesWhatAnalyzeGives) {
  const TempFolder folder;
  const std::string source = "synthetic://side-kicks?size=160x120&fps=15&duration=3&depth=1&clothes=wall";
  for (const auto* segmentation : {"depth", "both"}) {
    const std::string name = segmentation;
    auto arguments =
        by(segmentation, {"live", source, "--headless", "--pace", "max", "--out", folder / name + "-live"});
    const auto run = choreoscope(arguments);
    ASSERT_EQ(run.status, 0) << run.told();
    analyze(source, folder / name, by(segmentation, {"--set", "working.rows=120", "--background", "first:2s"}));
    for (const auto* file : {"/z.npy", "/zstar.npy", "/frames.csv"}) {
      EXPECT_EQ(read_bytes(folder / name + "-live" + file), read_bytes(folder / name + file)) << name << file;
    }
  }
}

TEST(Depth, OfASourceWithoutDepthItIsRefusedBeforeAnythingIsWritten) {
  for (const auto* segmentation : {"depth", "both"}) {
    const TempFolder folder;
    const auto run = choreoscope(
        by(segmentation, {"analyze", "synthetic://walking?size=64x48&duration=3", "--out", folder / "out"}));
    EXPECT_THAT(complaint_of(run, 2), HasSubstr("\"synthetic://walking?size=64x48&duration=3\" has no depth"));
    EXPECT_THAT(hint_of(run), HasSubstr("synthetic://SCRIPT?depth=1"));
    EXPECT_TRUE(files_in(folder / "out").empty());
  }
}

TEST(Depth, PlanesInTheWrongOrderAreRefusedBeforeAnythingIsRead) {
  const TempFolder folder;
  const auto run = choreoscope({"analyze", "synthetic://walking?size=64x48&depth=1", "--out", folder / "out", "--set",
                                "segmentation=depth", "--set", "depth.near_mm=4000", "--set", "depth.far_mm=1000"});
  EXPECT_THAT(complaint_of(run, 2), HasSubstr("depth.far_mm is 1000 and depth.near_mm is 4000"));
}

TEST(Depth, AClipOfSynthHoldsNone) {
  const TempFolder folder;
  const auto run = choreoscope({"synth", "walking?size=64x48&depth=1", "-o", folder / "clip.mkv"});
  EXPECT_THAT(complaint_of(run, 2), HasSubstr("holds no depth"));
}

}  // namespace
}  // namespace choreo::test
