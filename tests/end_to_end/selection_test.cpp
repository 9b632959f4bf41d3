// SPDX-License-Identifier: Apache-2.0
// Which frames are taken, how they hang, and where the background comes from.
#include <cmath>

#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "devices/synthetic/performer.hpp"
#include "end_to_end/choreoscope_run.hpp"
#include "support/make_video.hpp"

namespace choreo::test {
namespace {

const std::vector<std::string> kPlain{"--set", "plot.width_px=320", "--set", "plot.thumbnails=0"};

Results analyzed(const std::string& source, std::vector<std::string> more) {
  const TempFolder folder;
  more.insert(more.end(), kPlain.begin(), kPlain.end());
  analyze(source, folder / "out", more);
  return Results(folder / "out");
}

TEST(Selection, SpanAndEveryGiveTheFramesTheyPromise) {
  // 90 frames at 30 a second: frame k, counted from 1, stands at (k - 1) / 30 s.
  const std::string clip = "synthetic://jumping-jacks?size=64x48&duration=2";
  struct Case {
    std::vector<std::string> arguments;
    std::vector<int> frames;
  };
  const auto run_of = [](int first, int last, int step) {
    std::vector<int> frames;
    for (int i = first; i <= last; i += step) frames.push_back(i);
    return frames;
  };
  const std::vector<Case> cases{
      {{}, run_of(1, 90, 1)},
      {{"--every", "7"}, run_of(1, 90, 7)},
      {{"--every", "1000000"}, {1}},
      {{"--span", "1:2"}, run_of(31, 60, 1)},  // Half open: 1 s is in, 2 s is not.
      {{"--span", "1:"}, run_of(31, 90, 1)},
      {{"--span", ":500ms"}, run_of(1, 15, 1)},
      {{"--span", "31f:60f"}, run_of(31, 60, 1)},  // Both ends in.
      {{"--span", "90f:90f"}, {90}},
      {{"--span", "80f:1000f"}, run_of(80, 90, 1)},
      {{"--span", "1:2", "--every", "10"}, {31, 41, 51}},
      {{"--span", "32f:", "--every", "25"}, {32, 57, 82}},
  };
  for (const auto& c : cases) {
    const auto r = analyzed(clip, c.arguments);
    const auto what = ::testing::PrintToString(c.arguments);
    ASSERT_EQ(r.n, c.frames.size()) << what;
    for (std::size_t i = 0; i < r.n; ++i) EXPECT_NEAR(r.time_s[i], (c.frames[i] - 1) / 30.0, 1e-9) << what;
    EXPECT_EQ(r.z_values.size(), r.n * r.n) << what;
  }
}

TEST(Selection, AVariableFrameRateIsKept) {
  const TempFolder folder;
  VideoRecipe recipe;
  recipe.times = {1000, 1040, 1041, 1200, 2500, 2533};  // Milliseconds; the first is the source's zero.
  recipe.width = 64;
  recipe.height = 48;
  make_video(folder / "variable.mkv", recipe);
  const auto r = analyzed(folder / "variable.mkv", {});
  EXPECT_THAT(r.time_s, ::testing::Pointwise(::testing::DoubleNear(1e-9), {0.0, 0.04, 0.041, 0.2, 1.5, 1.533}));
  const auto part = analyzed(folder / "variable.mkv", {"--span", "0.041:1.5"});
  EXPECT_THAT(part.time_s, ::testing::Pointwise(::testing::DoubleNear(1e-9), {0.041, 0.2}));
}

TEST(Selection, TheFramesOfAFolderHaveItsRate) {
  const TempFolder folder;
  for (int i = 8; i < 12; ++i) {
    ASSERT_TRUE(cv::imwrite(folder / "p" + std::to_string(i) + ".png", cv::Mat(48, 64, CV_8UC3, cv::Scalar(9, 9, 9))));
  }
  const auto r = analyzed(folder.path() + "?fps=12.5", {});
  EXPECT_THAT(r.time_s, ::testing::Pointwise(::testing::DoubleNear(1e-9), {0.0, 0.08, 0.16, 0.24}));
}

// The masks of a run, one after the other.
std::vector<cv::Mat> masks_of(const std::string& source, std::vector<std::string> more = {}) {
  const TempFolder folder;
  more.insert(more.end(), kPlain.begin(), kPlain.end());
  more.insert(more.end(), {"--save", "masks"});
  analyze(source, folder / "out", more);
  const auto file = read_npy(folder / "out/masks.npy");
  const auto rows = static_cast<int>(file.shape.at(1));
  const auto cols = static_cast<int>(file.shape.at(2));
  std::vector<cv::Mat> masks;
  for (std::size_t i = 0; i < file.shape[0]; ++i) {
    const auto* first = file.data.data() + i * file.shape[1] * file.shape[2];
    masks.push_back(cv::Mat(rows, cols, CV_8UC1, const_cast<std::uint8_t*>(first)).clone());
  }
  return masks;
}

double mean_iou(const std::vector<cv::Mat>& a, const std::vector<cv::Mat>& b) {
  EXPECT_EQ(a.size(), b.size());
  double sum = 0;
  int bodies = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    if (a[i].size() != b[i].size()) return 0;
    const int whole = cv::countNonZero(a[i] | b[i]);
    if (whole == 0) continue;
    sum += double(cv::countNonZero(a[i] & b[i])) / whole;
    ++bodies;
  }
  EXPECT_GT(bodies, 0);
  return bodies > 0 ? sum / bodies : 0;
}

constexpr auto kSideways = "synthetic://side-kicks?size=160x120&fps=15&duration=2&seed=3";

TEST(Selection, AFlippedOrTurnedClipHasTheFlippedOrTurnedMask) {
  const auto upright = masks_of(kSideways);
  const auto changed = [&](const std::function<void(const cv::Mat&, cv::Mat&)>& change) {
    std::vector<cv::Mat> all;
    for (const auto& mask : upright) change(mask, all.emplace_back());
    return all;
  };
  const std::string clip = kSideways;
  // Not to the last pixel: what is learned in rows and columns may round another way round.
  EXPECT_GT(mean_iou(masks_of(clip + "&flip=horizontal"),
                     changed([](const cv::Mat& from, cv::Mat& to) { cv::flip(from, to, 1); })),
            0.99);
  EXPECT_GT(mean_iou(masks_of(clip + "&flip=vertical"),
                     changed([](const cv::Mat& from, cv::Mat& to) { cv::flip(from, to, 0); })),
            0.99);
  EXPECT_GT(mean_iou(masks_of(clip + "&rotate=90"),
                     changed([](const cv::Mat& from, cv::Mat& to) { cv::rotate(from, to, cv::ROTATE_90_CLOCKWISE); })),
            0.99);
  EXPECT_LT(mean_iou(masks_of(clip + "&flip=horizontal"), upright), 0.9) << "the clip is its own mirror image";
}

TEST(Selection, APlateAndTheFirstSecondGiveTheMasksOfTheWholeClip) {
  const TempFolder folder;
  devices::synthetic::PerformerSettings settings;
  settings.size = {160, 120};
  settings.seed = 3;
  const devices::synthetic::Performer performer("side-kicks", settings);
  ASSERT_TRUE(cv::imwrite(folder / "plate.png", performer.room()));
  const auto whole = masks_of(kSideways);
  EXPECT_GT(mean_iou(masks_of(kSideways, {"--background", "first:1s"}), whole), 0.97);
  EXPECT_GT(mean_iou(masks_of(kSideways, {"--background", folder / "plate.png"}), whole), 0.97);
}

}  // namespace
}  // namespace choreo::test
