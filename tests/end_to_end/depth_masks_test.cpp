// SPDX-License-Identifier: Apache-2.0
// Masks by depth where colour fails: clothes like the wall, and performers who never leave.
#include <cstdlib>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "end_to_end/choreoscope_run.hpp"
#include "end_to_end/mask_truth.hpp"
#include "support/long_lane.hpp"

namespace choreo::test {
namespace {

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

TEST(DepthMasks, ColourAloneLosesClothesLikeTheWall) {
  const auto source = clip("side-kicks?seed=2", "size=320x240&fps=10&duration=3&empty=1");
  EXPECT_LT(mean_iou(source, by("colour")), 0.65) << "else the tests above show nothing";
}

TEST(DepthMasks, AtTheSizeOfAKinectAlmostNothingIsLost) {
  EXPECT_GE(mean_iou(clip("side-kicks?seed=2", "size=640x480&fps=10&duration=2&empty=1"), by("both")), 0.975);
}

TEST(DepthMasks, AsLiveWorksThePerformerWhoNeverLeavesIsWholeToo) {
  const auto source = clip("limp?seed=5", "size=640x480&fps=15&duration=4&empty=0");
  EXPECT_GE(mean_iou(source, by("both", {"--background", "first:2s", "--set", "working.rows=120"}), 2), 0.90);
}

TEST(DepthMasks, BothIsAsGoodAsColourWhereColourIsGood) {
  const std::string source = "synthetic://jumping-jacks?seed=4&size=320x240&fps=10&duration=3&depth=1";
  EXPECT_GE(mean_iou(source, by("both")), mean_iou(source, by("colour")) - 0.01);
}

TEST(DepthMasks, NobodyIsSeenInAnEmptyRoomBeforeAndAfter) {
  // What mean_iou expects of frames whose truth has no body.
  EXPECT_GE(mean_iou("synthetic://crossing?size=320x240&fps=10&seed=12&depth=1", by("depth")), 0.93);
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
