// SPDX-License-Identifier: Apache-2.0
// What analyze writes: every file and its shape, and that they tell the same.
#include <cmath>
#include <fstream>
#include <sstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "end_to_end/choreoscope_run.hpp"
#include "support/outdoors.hpp"
#include "support/places.hpp"

namespace choreo::test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

/// One line a frame, cells by column name.
std::vector<std::map<std::string, std::string>> read_csv(const std::string& path) {
  const auto cells_of = [](const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream in(line);
    for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
    return cells;
  };
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  const auto names = cells_of(line);
  std::vector<std::map<std::string, std::string>> rows;
  while (std::getline(file, line)) {
    const auto cells = cells_of(line);
    EXPECT_EQ(cells.size(), names.size()) << line;
    auto& row = rows.emplace_back();
    for (std::size_t i = 0; i < std::min(cells.size(), names.size()); ++i) row[names[i]] = cells[i];
  }
  return rows;
}

TEST(AnalyzeOutputs, AllFilesAreThereAndAgreeOnTheNumberOfFrames) {
  const TempFolder folder;
  const auto out = folder / "made/on/the/way";
  const auto run = analyze("synthetic://jumping-jacks?size=320x240&duration=2", out, {"--save", "masks"});
  const std::set<std::string> wanted{"plot.png",  "triangle.png", "z.npy",        "zstar.npy",
                                     "times.npy", "frames.csv",   "summary.json", "masks.npy"};
  EXPECT_EQ(files_in(out), wanted);
  for (const auto& name : wanted) EXPECT_NE(run.out.find(out + "/" + name + "\n"), std::string::npos) << name;

  const Results r(out);
  ASSERT_EQ(r.n, 90u);  // One second of empty room and two of jumping, at 30 a second.
  const std::vector<std::size_t> square{90, 90};
  EXPECT_EQ(r.z.shape, square);
  EXPECT_EQ(r.zstar.shape, square);
  EXPECT_EQ(r.times.shape, std::vector<std::size_t>{90});
  EXPECT_EQ(r.z.dtype, "<f4");
  EXPECT_EQ(r.zstar.dtype, "<f4");
  EXPECT_EQ(r.times.dtype, "<f8");
  const auto masks = read_npy(out + "/masks.npy");
  EXPECT_EQ(masks.dtype, "|u1");
  EXPECT_EQ(masks.shape, (std::vector<std::size_t>{90, 240, 320}));
  const auto pixels = masks.values<std::uint8_t>();
  EXPECT_EQ(*std::max_element(pixels.begin(), pixels.end()), 1);
  for (std::size_t i = 0; i < r.n; ++i) EXPECT_NEAR(r.time_s[i], double(i) / 30, 1e-9);

  EXPECT_EQ(r.summary["frames"], 90);
  EXPECT_EQ(r.summary["frames_without_body"], 30);
  EXPECT_EQ(r.summary["size"], nlohmann::json({320, 240}));
  EXPECT_EQ(r.summary["working_size"], nlohmann::json({320, 240}));
  EXPECT_EQ(r.summary["source"], "synthetic://jumping-jacks?size=320x240&duration=2");
  EXPECT_EQ(r.summary["background"]["uncertain"], false);
  EXPECT_EQ(r.summary["interrupted"], false);
  EXPECT_EQ(r.summary["warnings"], nlohmann::json::array());
  EXPECT_EQ(r.summary["settings"]["working.rows"], 480);
  EXPECT_TRUE(r.summary["timings"].contains("stages"));
  EXPECT_EQ(r.summary["files"].size(), wanted.size());
  for (const auto* name : {"plot.png", "triangle.png"}) {
    const auto plot = cv::imread(out + "/" + name);
    EXPECT_EQ(plot.cols, 1600) << name;
    EXPECT_GT(plot.rows, 300) << name;
  }
}

TEST(AnalyzeOutputs, TheTableTheMatricesAndTheMasksTellTheSameStory) {
  const TempFolder folder;
  analyze("synthetic://reflected-state?size=320x240&fps=15&seed=4", folder / "out", {"--save", "masks"});
  const Results r(folder / "out");
  const auto rows = read_csv(folder / "out/frames.csv");
  const auto masks = read_npy(folder / "out/masks.npy").values<std::uint8_t>();
  ASSERT_EQ(rows.size(), r.n);
  std::size_t without = 0;
  for (std::size_t i = 0; i < r.n; ++i) {
    const auto& row = rows[i];
    const cv::Mat mask(240, 320, CV_8UC1, const_cast<std::uint8_t*>(masks.data() + i * 240 * 320));
    const int area = cv::countNonZero(mask);
    EXPECT_EQ(std::stoi(row.at("frame")), static_cast<int>(i) + 1);
    EXPECT_NEAR(std::stod(row.at("time_s")), r.time_s[i], 1e-6);
    if (row.at("body") == "0") {
      ++without;
      EXPECT_EQ(area, 0);
      EXPECT_EQ(row.at("area_px"), "nan");
      // A row, a column and a diagonal entry of NaN.
      for (std::size_t k = 0; k < r.n; ++k) {
        ASSERT_TRUE(std::isnan(r.Z(i, k)) && std::isnan(r.Z(k, i)) && std::isnan(r.Zstar(i, k)) &&
                    std::isnan(r.Zstar(k, i)));
      }
      continue;
    }
    EXPECT_EQ(std::stoi(row.at("area_px")), area);
    const auto moments = cv::moments(mask, true);
    EXPECT_NEAR(std::stod(row.at("centroid_x_px")), moments.m10 / moments.m00, 6e-4);
    EXPECT_NEAR(std::stod(row.at("centroid_y_px")), moments.m01 / moments.m00, 6e-4);
    const auto box = cv::boundingRect(mask);
    EXPECT_EQ(row.at("box_x_px") + " " + row.at("box_y_px"), std::to_string(box.x) + " " + std::to_string(box.y));
    EXPECT_EQ(row.at("box_width_px") + " " + row.at("box_height_px"),
              std::to_string(box.width) + " " + std::to_string(box.height));
    EXPECT_NEAR(std::stod(row.at("zstar_tt")), r.Zstar(i, i), 1e-6);
    EXPECT_EQ(r.Z(i, i), 1);
    for (std::size_t k = 0; k < i; ++k) {
      if (rows[k].at("body") == "0") continue;
      ASSERT_TRUE(r.Z(i, k) == r.Z(k, i) && r.Z(i, k) >= 0 && r.Z(i, k) <= 1);
      ASSERT_TRUE(r.Zstar(i, k) == r.Zstar(k, i) && r.Zstar(i, k) >= 0 && r.Zstar(i, k) <= 1);
    }
  }
  EXPECT_EQ(r.summary["frames_without_body"], without);
  EXPECT_GT(without, 0u);
  EXPECT_GT(r.n, without) << "there is a body to tell of";
}

// A tree in the wind, and somebody who walks past it.
TEST(AnalyzeOutputs, LeavesInTheWindAreNoBodyAndAreToldOfWithTheSettingThatLeavesThemOut) {
  const TempFolder folder;
  const auto scene = garden(3, 11);
  std::filesystem::create_directory(folder / "garden");
  for (std::size_t k = 0; k < scene.pictures.size(); ++k) {
    cv::imwrite(fmt::format("{}/{:04}.png", folder / "garden", k), scene.pictures[k]);
  }
  const auto run = analyze((folder / "garden") + "?fps=15", folder / "out",
                           {"--save", "masks", "--set", "segmentation=colour", "--set", "plot.width_px=320"});
  // The tree is from 0.44 of the width on, and down to 0.67 of the height.
  EXPECT_THAT(run.err_lines("choreoscope: warning: "),
              Contains(AllOf(HasSubstr("of the picture moves in place"), HasSubstr("mask.ignore = [[0.4"))));
  const auto masks = read_npy(folder / "out/masks.npy");
  std::vector<cv::Mat> found;
  for (std::size_t k = 0; k < scene.pictures.size(); ++k) {
    found.emplace_back(
        255 * cv::Mat(kOutdoorsSize, CV_8UC1, const_cast<std::uint8_t*>(masks.data.data()) + k * kOutdoorsSize.area()));
  }
  EXPECT_GT(f_measure(found, scene.truths), 0.93);
}

class BundledRecording : public ::testing::TestWithParam<const char*> {};

TEST_P(BundledRecording, IsAnalysedWithoutAWarning) {
  const TempFolder folder;
  const auto run = analyze(project_file("recordings/") + GetParam(), folder / "out", {"--every", "4"});
  EXPECT_TRUE(run.err_lines("choreoscope: warning: ").empty()) << run.told();
}

INSTANTIATE_TEST_SUITE_P(All, BundledRecording,
                         ::testing::Values("side-kicks.mp4", "walking.mp4", "jumping-jacks.mp4", "anti-palindrome.mp4",
                                           "semaphore-dance.mp4"));

}  // namespace
}  // namespace choreo::test
