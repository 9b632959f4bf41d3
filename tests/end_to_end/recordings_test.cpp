// SPDX-License-Identifier: Apache-2.0
// Recordings of people, which are not part of this repository: they are analysed, and well.
#include <fstream>

#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "end_to_end/choreoscope_run.hpp"
#include "support/shared_data.hpp"

namespace choreo::test {
namespace {

#define CHOREO_NEED(path, name)        \
  const auto path = shared_data(name); \
  if (path.empty()) GTEST_SKIP() << name << " is not below ../shared/data or $CHOREO_SHARED_DATA"

RunOptions patient() {
  RunOptions options;
  options.limit = std::chrono::seconds(580);
  return options;
}

TEST(Recordings, EveryVideoEndsWithAPlot) {
  CHOREO_NEED(videos, "video");
  int count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(videos)) {
    const auto ending = entry.path().extension();
    if (ending != ".mp4" && ending != ".mkv" && ending != ".webm" && ending != ".avi" && ending != ".mov") continue;
    const TempFolder folder;
    const auto name = entry.path().filename().string();
    // Short clips whole, of long ones the first half minute.
    analyze(entry.path().string(), folder / "out", {"--every", "5", "--span", "0:30"}, patient());
    const Results r(folder / "out");
    EXPECT_GT(r.n, 10u) << name;
    EXPECT_LT(r.summary["frames_without_body"], r.n) << name;
    for (const auto* plot : {"plot.png", "triangle.png"}) {
      EXPECT_FALSE(cv::imread(folder / "out/" + plot).empty()) << name;
    }
    ++count;
  }
  EXPECT_GE(count, 3);
}

TEST(Recordings, WhereTheRoomIsNeverEmptyTheSummarySaysThatTheBackgroundIsUncertain) {
  for (const auto* name : {"video/clear/pose2sim_single_cam01.mp4", "video/clear/pose2sim_single_cam02.mp4"}) {
    CHOREO_NEED(clip, name);
    const TempFolder folder;
    const auto run = analyze(clip, folder / "out", {}, patient());
    const Results r(folder / "out");
    EXPECT_EQ(r.n, 100u) << name;
    EXPECT_EQ(r.summary["background"]["uncertain"], true) << name;
    EXPECT_GT(r.summary["background"]["share_of_body_before_unseen_wall"], 0.02) << name;
    EXPECT_THAT(run.err_lines("choreoscope: warning: "), ::testing::Contains(::testing::HasSubstr("uncertain")))
        << name;
  }
}

cv::Mat filled(const nlohmann::json& polygons, cv::Size size) {
  constexpr int kShift = 4;  // Corners to a sixteenth of a pixel.
  cv::Mat mask = cv::Mat::zeros(size, CV_8UC1);
  for (const auto& polygon : polygons) {
    std::vector<cv::Point> corners;
    for (const auto& corner : polygon) {
      corners.emplace_back(cvRound(corner[0].get<double>() * (1 << kShift)),
                           cvRound(corner[1].get<double>() * (1 << kShift)));
    }
    cv::fillPoly(mask, std::vector<std::vector<cv::Point>>{corners}, 255, cv::LINE_8, kShift);
  }
  return mask;
}

TEST(Recordings, OutlinesByHandAgreeWithTheMasksAndNobodyIsInTheEmptyRoom) {
  std::ifstream file(std::string(CHOREO_PROJECT_ROOT) + "/tests/data/outlines/intel_one_by_one.json");
  const auto outlines = nlohmann::json::parse(file);
  ASSERT_EQ(outlines["frames"].size(), 6u);
  CHOREO_NEED(clip, outlines["clip"].get<std::string>());
  const TempFolder folder;
  analyze(clip, folder / "out", {"--save", "masks"}, patient());
  const auto mask_at = [&](std::size_t frame) {
    const auto one = read_npy(folder / "out/masks.npy", frame - 1, 1);
    const cv::Mat view(static_cast<int>(one.shape.at(1)), static_cast<int>(one.shape.at(2)), CV_8UC1,
                       const_cast<std::uint8_t*>(one.data.data()));
    return cv::Mat(view != 0);
  };
  for (const auto& frame : outlines["frames"]) {
    const auto number = frame["frame"].get<std::size_t>();
    const auto mask = mask_at(number);
    ASSERT_EQ(mask.size(), cv::Size(768, 432));
    const cv::Mat truth = filled(frame["body"], mask.size()) & ~filled(frame["holes"], mask.size());
    const double iou = double(cv::countNonZero(mask & truth)) / double(cv::countNonZero(mask | truth));
    std::printf("frame %zu: IoU %.3f\n", number, iou);
    EXPECT_GE(iou, 0.85) << "frame " << number;
  }
  for (const auto& range : outlines["empty"]) {
    for (auto number = range[0].get<std::size_t>(); number <= range[1].get<std::size_t>(); ++number) {
      EXPECT_EQ(cv::countNonZero(mask_at(number)), 0) << "a body in the empty room of frame " << number;
    }
  }
}

}  // namespace
}  // namespace choreo::test
