// SPDX-License-Identifier: Apache-2.0
// The masks and the signs of a second drawn performer, a flat cartoon that nothing was tuned to.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "end_to_end/choreoscope_run.hpp"
#include "support/flat_performer.hpp"
#include "support/long_lane.hpp"
#include "support/make_video.hpp"

namespace choreo::test {
namespace {

constexpr int kFlatFps = 15;

void film(const FlatPerformer& performer, int frames, const cv::Size& size, const std::string& path,
          int fps = kFlatFps) {
  VideoRecipe recipe;
  recipe.width = size.width;
  recipe.height = size.height;
  recipe.time_base = {1, fps};
  recipe.rate = {fps, 1};
  recipe.duration = 1;
  recipe.times.clear();
  for (int k = 0; k < frames; ++k) recipe.times.push_back(k);
  recipe.paint = [&, fps](AVFrame& frame, int index) {
    cv::Mat plane(size, CV_8UC4, frame.data[0], std::size_t(frame.linesize[0]));
    cv::cvtColor(performer.frame(double(index) / fps).picture, plane, cv::COLOR_BGR2BGRA);
  };
  make_video(path, recipe);
}

struct FlatCase {
  const char* name;
  int look;
  const char* script;
  double empty_s;
  double chair_at_s;
  int frames;
  double least = 0.95;  ///< Mean intersection over union; where less, what was measured, which may not become worse.
};
void PrintTo(const FlatCase& c, std::ostream* out) { *out << c.name; }

class FlatPerformerMasks : public ::testing::TestWithParam<FlatCase> {};

TEST_P(FlatPerformerMasks, AreWholeAndNothingElseIs) {
  if (const auto missing = missing_person_network(); !missing.empty()) GTEST_SKIP() << missing << " is not here";
  const auto& c = GetParam();
  FlatScene scene;
  scene.look = c.look;
  scene.script = c.script;
  scene.empty_s = c.empty_s;
  scene.chair_at_s = c.chair_at_s;
  scene.seed = unsigned(c.look) + 1;
  const FlatPerformer performer(scene);
  const TempFolder folder;
  film(performer, c.frames, scene.size, folder / "clip.mkv");
  analyze_with_network(folder / "clip.mkv", folder / "out",
                       {"--save", "masks", "--set", "plot.width_px=320", "--set", "plot.thumbnails=0"});
  const auto file = read_npy(folder / "out/masks.npy");
  ASSERT_EQ(file.shape[0], std::size_t(c.frames));
  double sum = 0, worst = 1;
  int bodies = 0, empty = 0, wrong = 0;
  for (int k = 0; k < c.frames; ++k) {
    const auto truth_of = performer.frame(double(k) / kFlatFps);
    const cv::Mat truth = truth_of.body | truth_of.held;
    const cv::Mat mask(scene.size, CV_8UC1,
                       const_cast<std::uint8_t*>(file.data.data()) + std::size_t(k) * truth.total());
    const double percent = 100.0 * cv::countNonZero(truth) / double(truth.total());
    if (percent < 0.4) {
      ++empty;
      wrong += cv::countNonZero(mask) > 0 ? 1 : 0;
    }
    if (percent < 0.6) continue;
    const double overlap = double(cv::countNonZero(mask & truth)) / double(cv::countNonZero(mask | truth));
    sum += overlap;
    worst = std::min(worst, overlap);
    ++bodies;
  }
  std::printf("| flat performer, %s | %.3f (%.3f) | %d of %d |\n", c.name, sum / bodies, worst, wrong, empty);
  EXPECT_GE(sum / bodies, c.least);
  EXPECT_EQ(wrong, 0);
}

INSTANTIATE_TEST_SUITE_P(Scenes, FlatPerformerMasks,
                         ::testing::ValuesIn(some_of<FlatCase>(
                             {{"T-shirt, comes in", 0, "dance", 1, -1, 120},
                              {"flags and a jacket like the wall, never leaves", 2, "dance", 0, -1, 90, 0.945},
                              {"dress, never leaves", 1, "dance", 0, -1, 90},
                              {"T-shirt, never leaves, moves the arms alone", 0, "wave", 0, -1, 90},
                              {"dress, comes in and stands; a chair is set down", 1, "stand", 1, 5, 150},
                              {"flags and a jacket like the wall, comes in", 2, "wave", 1, -1, 120},
                              {"dress, never leaves, stands still", 1, "stand", 0, -1, 60}},
                             2)));

struct FlatSignals {
  const char* name;
  int look;
  double bend;
  unsigned seed;
  int least = 4;                                    ///< Letters that are read,
  int wrong = 0;                                    ///< and those that are others; what was measured and a letter less.
  const char* text = "THEQUICKBROWNFXJMPSVLAZYDG";  ///< Every letter.
};
void PrintTo(const FlatSignals& c, std::ostream* out) { *out << c.name; }

class FlatPerformerSignals : public ::testing::TestWithParam<FlatSignals> {};

// Three tones of skin, half and long sleeves, a dress's wide ones, flags; furniture of skin's colours.
TEST_P(FlatPerformerSignals, AreRead) {
  if (const auto missing = missing_person_network(); !missing.empty()) GTEST_SKIP() << missing << " is not here";
  const auto& c = GetParam();
  FlatScene scene;
  scene.look = c.look;
  scene.script = "signal";
  scene.text = c.text;
  scene.bend = c.bend;
  scene.empty_s = 0;
  scene.seed = c.seed;
  const TempFolder folder;
  constexpr int kFps = 10;
  film(FlatPerformer(scene), int(seconds_of_text(c.text) * kFps), scene.size, folder / "clip.mkv", kFps);
  RunOptions patient;
  patient.limit = std::chrono::minutes(8);
  analyze_with_network(folder / "clip.mkv", folder / "out",
                       {"--recognise", "semaphore", "--state", "mask", "--set", "plot.width_px=320"}, patient);
  const auto bytes = read_bytes(folder / "out/letters.json");
  const auto json = nlohmann::json::parse(bytes.begin(), bytes.end());
  // Each letter within its own time.
  std::string read(scene.text.size(), '-');
  int wrong = 0;
  for (const auto& letter : json["letters"]) {
    const double middle = (letter["from"].get<double>() + letter["to"].get<double>()) / 2;
    const auto k = std::size_t(std::clamp((middle - 1) / 2.5, 0.0, double(read.size() - 1)));
    const auto shown = letter["letter"].get<std::string>();
    read[k] = shown.size() == 1 ? shown[0] : '?';
    wrong += read[k] == scene.text[k] ? 0 : 1;
  }
  int right = 0;
  for (std::size_t k = 0; k < read.size(); ++k) right += read[k] == scene.text[k] ? 1 : 0;
  std::printf("| flat performer, %s | %d of %zu | %d | %s |\n", c.name, right, read.size(), wrong, read.c_str());
  EXPECT_GE(right, c.least) << read;
  EXPECT_LE(wrong, c.wrong) << read;
}

struct FlatStills {
  int look;
  double bend;
  const char* letters;
  int least;  ///< As of FlatSignals.
  int wrong = 0;
};
void PrintTo(const FlatStills& c, std::ostream* out) { *out << "look " << c.look << ", bent by " << c.bend; }

class FlatPerformerStills : public ::testing::TestWithParam<FlatStills> {};

TEST_P(FlatPerformerStills, AreReadEachByItself) {
  if (const auto missing = missing_person_network(); !missing.empty()) GTEST_SKIP() << missing << " is not here";
  const auto& c = GetParam();
  FlatScene scene;
  scene.look = c.look;
  scene.script = "signal";
  scene.text = c.letters;
  scene.bend = c.bend;
  scene.empty_s = 0;
  scene.seed = unsigned(c.look) + 1;
  const FlatPerformer performer(scene);
  const TempFolder folder;
  const auto set = folder / "set";
  std::filesystem::create_directory(set);
  for (std::size_t k = 0; k < scene.text.size(); ++k) {
    cv::imwrite(fmt::format("{}/{}_.png", set, scene.text[k]), performer.frame(2.8 + 2.5 * double(k)).picture);
  }
  analyze_with_network(set, folder / "out", {"--recognise", "semaphore"});
  const auto bytes = read_bytes(folder / "out/letters.json");
  int right = 0, wrong = 0;
  const auto json = nlohmann::json::parse(bytes.begin(), bytes.end());
  for (const auto& picture : json["pictures"]) {
    if (picture["letter"].is_null()) continue;
    const bool same = picture["letter"].get<std::string>() == picture["file"].get<std::string>().substr(0, 1);
    (same ? right : wrong) += 1;
  }
  std::printf("| stills, look %d, bent by %.0f degrees | %d of %zu | %d |\n", c.look, c.bend, right, scene.text.size(),
              wrong);
  EXPECT_GE(right, c.least);
  EXPECT_LE(wrong, c.wrong);
}

constexpr const char* kAll = "ABCDEFGHIJKLMNOPQRSTUVWXYZ";
INSTANTIATE_TEST_SUITE_P(Looks, FlatPerformerStills,
                         ::testing::ValuesIn(some_of<FlatStills>({{2, 0, "BEMPQRUZ", 7},
                                                                  {0, 0, kAll, 25},
                                                                  {0, 24, kAll, 25},
                                                                  {1, 0, kAll, 23, 1},
                                                                  {1, 24, kAll, 24},
                                                                  {2, 0, kAll, 21},
                                                                  {2, 24, kAll, 23}},
                                                                 1)));

INSTANTIATE_TEST_SUITE_P(
    Scenes, FlatPerformerSignals,
    ::testing::ValuesIn(some_of<FlatSignals>({{"dress, bent arms, a few letters", 1, 24, 2, 4, 0, "HOWA"},
                                              {"T-shirt", 0, 0, 1, 25, 0},
                                              {"T-shirt, bent arms", 0, 24, 2, 25, 0},
                                              {"dress", 1, 0, 3, 24, 0},
                                              {"dress, bent arms", 1, 24, 1, 25, 0},
                                              {"flags and a jacket like the wall", 2, 0, 2, 24, 0},
                                              {"flags and a jacket like the wall, bent arms", 2, 24, 3, 25, 0}},
                                             1)));

}  // namespace
}  // namespace choreo::test
