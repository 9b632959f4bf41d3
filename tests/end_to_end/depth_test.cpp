// SPDX-License-Identifier: Apache-2.0
// Masks by depth where colour fails: clothes like the wall, and performers who never leave; and what is refused.
#include <cstdlib>

#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

#include "end_to_end/choreoscope_run.hpp"
#include "end_to_end/mask_truth.hpp"
#include "support/long_lane.hpp"

namespace choreo::test {
namespace {

using ::testing::HasSubstr;

std::vector<std::string> by(const std::string& segmentation, std::vector<std::string> more = {}) {
  more.insert(more.end(), {"--set", "segmentation=" + segmentation});
  return more;
}

std::string clip(const std::string& script, const std::string& more) {
  return "synthetic://" + script + "&clothes=wall&depth=1&" + more;
}

const std::vector<const char*> kScripts = {"jumping-jacks?seed=1", "side-kicks?seed=2", "semaphore?seed=3",
                                           "limp?seed=5", "idle?seed=6"};

class ClothesLikeTheWall : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Clips, ClothesLikeTheWall, ::testing::ValuesIn(some_of<const char*>(kScripts, 3)));

TEST_P(ClothesLikeTheWall, AreSeenByDepthAndBetterByBoth) {
  const auto source = clip(GetParam(), "size=320x240&fps=10&duration=3&empty=1");
  const double depth = mean_iou(source, by("depth"));
  EXPECT_GE(depth, 0.95);
  EXPECT_GE(mean_iou(source, by("both")), std::max(0.96, depth));
}

TEST_P(ClothesLikeTheWall, AreSeenThoughThePerformerNeverLeaves) {
  const auto source = clip(GetParam(), "size=320x240&fps=10&duration=5&empty=0");
  EXPECT_GE(mean_iou(source, by("depth")), 0.95);
}

TEST(Depth, ColourAloneLosesClothesLikeTheWall) {
  const auto source = clip("side-kicks?seed=2", "size=320x240&fps=10&duration=3&empty=1");
  EXPECT_LT(mean_iou(source), 0.65) << "else the tests above show nothing";
}

TEST(Depth, AtTheSizeOfAKinectAlmostNothingIsLost) {
  EXPECT_GE(mean_iou(clip("side-kicks?seed=2", "size=640x480&fps=10&duration=2&empty=1"), by("both")), 0.975);
}

TEST(Depth, AsLiveWorksThePerformerWhoNeverLeavesIsWholeToo) {
  const auto source = clip("limp?seed=5", "size=640x480&fps=15&duration=4&empty=0");
  EXPECT_GE(mean_iou(source, by("both", {"--background", "first:2s", "--set", "working.rows=120"}), 2), 0.90);
}

TEST(Depth, BothIsAsGoodAsColourWhereColourIsGood) {
  const std::string source = "synthetic://jumping-jacks?seed=4&size=320x240&fps=10&duration=3&depth=1";
  EXPECT_GE(mean_iou(source, by("both")), mean_iou(source) - 0.01);
}

TEST(Depth, NobodyIsSeenInAnEmptyRoomBeforeAndAfter) {
  // What mean_iou expects of frames whose truth has no body.
  EXPECT_GE(mean_iou("synthetic://crossing?size=320x240&fps=10&seed=12&depth=1", by("depth")), 0.93);
}

TEST(Depth, TheSummarySaysWhichSegmentationWasUsedAndWhatWasLearned) {
  const TempFolder folder;
  const std::string source = "synthetic://jumping-jacks?size=160x120&fps=10&duration=2&depth=1";
  analyze(source, folder / "colour");
  const auto colour = Results(folder / "colour").summary;
  EXPECT_EQ(colour["segmentation"], "colour");
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

// docs/images/depth-mask.png: colour, depth, and the masks by colour, by depth and by both, side by side. No test, but
// what docs/accuracy.md calls.
TEST(DepthPicture, DISABLED_IsDrawn) {
  const auto* path = std::getenv("CHOREO_DEPTH_PICTURE");
  ASSERT_NE(path, nullptr) << "CHOREO_DEPTH_PICTURE names no file to write";
  constexpr int kFrame = 25;
  const TempFolder folder;
  const auto source = clip("jumping-jacks?seed=1", "size=640x480&fps=10&duration=2&empty=1");
  const auto request =
      devices::performer_request(devices::parse_source_uri(source, [](const std::string&) { return false; }));
  const auto frame = devices::synthetic::Performer(request.script, request.settings).perform(kFrame);
  cv::Mat depth;
  frame.depth.convertTo(depth, CV_8U, -255.0 / 2200, 255.0 * 3700 / 2200);  // 1.5 m white, 3.7 m black
  cv::cvtColor(depth, depth, cv::COLOR_GRAY2BGR);
  depth.setTo(cv::Scalar(0, 0, 120), frame.depth == 0);
  std::vector<cv::Mat> row{frame.bgr, depth};
  for (const auto* segmentation : {"colour", "depth", "both"}) {
    analyze(source, folder / segmentation, by(segmentation, {"--save", "masks"}));
    const auto file = read_npy(folder / segmentation + "/masks.npy");
    const cv::Mat mask(480, 640, CV_8UC1, const_cast<std::uint8_t*>(file.data.data() + kFrame * 480 * 640));
    row.emplace_back();
    cv::cvtColor(cv::Mat(255 * mask), row.back(), cv::COLOR_GRAY2BGR);
  }
  // The part with the body in it.
  for (auto& picture : row) picture = picture(cv::Rect(190, 20, 260, 450));
  cv::Mat all;
  cv::hconcat(row, all);
  cv::resize(all, all, {}, 0.7, 0.7, cv::INTER_AREA);
  ASSERT_TRUE(cv::imwrite(path, all));
}

}  // namespace
}  // namespace choreo::test
