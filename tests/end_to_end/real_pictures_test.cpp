// SPDX-License-Identifier: Apache-2.0
// Pictures that nothing here was tuned to: what the program makes of them, as the table of docs/accuracy.md. Nothing
// may become worse than it was measured there.
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "end_to_end/choreoscope_run.hpp"
#include "support/long_lane.hpp"
#include "support/shared_data.hpp"

namespace choreo::test {
namespace {

class RealPictures : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!in_long_lane()) GTEST_SKIP() << "a measurement for script/test --long";
  }

  // The path of what is needed; the test is skipped by its name where it is not there.
  std::string needed(const std::string& name) {
    auto path = shared_data(name);
    if (path.empty()) skipped_ = "the recordings in ../shared/data are not here: " + name;
    return path;
  }

  static void row(const char* what, const std::string& figure) { std::printf("| %s | %s |\n", what, figure.c_str()); }

  // Pixels of body in every frame, and of the picture.
  struct Areas {
    std::vector<double> body;
    double picture = 0;

    [[nodiscard]] double mean_percent(std::size_t from) const {
      double sum = 0;
      for (auto k = from; k < body.size(); ++k) sum += body[k];
      return 100 * sum / double(body.size() - from) / picture;
    }
  };

  Areas areas_of(const std::string& clip, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"--save", "masks", "--set", "plot.width_px=320", "--set", "plot.thumbnails=0"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    RunOptions patient;
    patient.limit = std::chrono::minutes(8);
    analyze_with_network(clip, folder_ / "out", arguments, patient);
    const auto masks = read_npy(folder_ / "out/masks.npy");
    Areas areas;
    const auto size = masks.shape.at(1) * masks.shape.at(2);
    areas.picture = double(size);
    for (std::size_t k = 0; k < masks.shape.at(0); ++k) {
      const cv::Mat mask(1, int(size), CV_8UC1, const_cast<std::uint8_t*>(masks.data.data()) + k * size);
      areas.body.push_back(cv::countNonZero(mask));
    }
    return areas;
  }

  TempFolder folder_;
  std::string skipped_;
};

#define NEEDS_DATA(path) \
  if ((path).empty()) GTEST_SKIP() << skipped_

TEST_F(RealPictures, OfficePhotographsAndTheirLetters) {
  const auto labels = needed("gestures/labels.csv");
  NEEDS_DATA(labels);
  std::map<std::string, std::string> truth;
  std::ifstream file(labels);
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) truth[line.substr(0, line.find(','))] = line.substr(line.find(',') + 1);
  const auto folder = labels.substr(0, labels.rfind('/'));
  RunOptions patient;
  patient.limit = std::chrono::minutes(8);
  analyze_with_network(folder + "?stills=1", folder_ / "out", {"--recognise", "semaphore"}, patient);
  const auto text = read_bytes(folder_ / "out/letters.json");
  const auto read = nlohmann::json::parse(text.begin(), text.end());
  int labelled = 0, right = 0, others = 0, wrong = 0;
  for (const auto& picture : read.at("pictures")) {
    const auto letter = truth.at(picture.at("file").get<std::string>());
    if (letter == "?") continue;  // One may argue.
    const auto& sign = picture.at("letter");
    const auto given = sign.is_null() ? std::string() : sign.get<std::string>();
    labelled += letter.empty() ? 0 : 1;
    right += !letter.empty() && given == letter ? 1 : 0;
    others += letter.empty() ? 1 : 0;
    wrong += !given.empty() && given != letter ? 1 : 0;
  }
  row("office photographs with a letter, read", std::to_string(right) + " of " + std::to_string(labelled));
  row("letters read that are not there", std::to_string(wrong) + " of " + std::to_string(labelled + others));
  EXPECT_EQ(labelled, 30);
  EXPECT_GE(right, 28);
  EXPECT_LE(wrong, 1);
}

// The last frames show an empty room: its people left through the door.
TEST_F(RealPictures, ARoomThatPeopleLeft) {
  const auto clip = needed("video/clear/intel_people-detection.gif");
  NEEDS_DATA(clip);
  constexpr std::size_t kEmptyFrom = 15;
  const auto areas = areas_of(clip);
  ASSERT_GT(areas.body.size(), kEmptyFrom + 5);
  char figure[64];
  std::snprintf(figure, sizeof figure, "%.1f %%", areas.mean_percent(kEmptyFrom));
  row("of the picture that is body in a room that people left", figure);
  EXPECT_LE(areas.mean_percent(kEmptyFrom), 0.1);
}

// She on the left, he on the right; the camera moves with them.
TEST_F(RealPictures, TwoWhoWalk) {
  const auto clip = needed("video/clear/intel_face-demographics-walking.gif");
  NEEDS_DATA(clip);
  const auto left = areas_of(clip, {"--set", "person.choose=left"});
  const auto right = areas_of(clip, {"--set", "person.choose=right"});
  const auto both = areas_of(clip, {"--set", "person.others=bodies"});
  char figure[64];
  std::snprintf(figure, sizeof figure, "%.1f and %.1f, together %.1f %%", left.mean_percent(3), right.mean_percent(3),
                both.mean_percent(3));
  row("of the picture that is body, of two who walk", figure);
  EXPECT_LT(1.2 * left.mean_percent(3), right.mean_percent(3)) << "he is larger";
  EXPECT_NEAR(both.mean_percent(3), left.mean_percent(3) + right.mean_percent(3), 0.1 * both.mean_percent(3));
}

// A drawn figure is there in 60 of every 100 frames, from the 31st on; from the 201st on a chair stands where none
// stood.
TEST_F(RealPictures, AChairThatIsSetDown) {
  const auto clip = needed("cases/bg_chair.mp4");
  NEEDS_DATA(clip);
  const auto areas = areas_of(clip);
  ASSERT_EQ(areas.body.size(), 600u);
  int bodies = 0, empty = 0;
  for (std::size_t k = 0; k < areas.body.size(); ++k) {
    if (k % 100 >= 30 && k % 100 < 90) continue;
    ++empty;
    bodies += areas.body[k] > 0 ? 1 : 0;
  }
  row("empty frames with a body, where a chair is set down", std::to_string(bodies) + " of " + std::to_string(empty));
  EXPECT_LE(bodies, 40);
}

// The room is empty for a second, so that it is known; the signaller, who stands still, has 5890 pixels.
TEST_F(RealPictures, WhoStandsBeforeFurnitureInARoomThatWasSeen) {
  const auto clip = needed("cases/stands_before_furniture.mkv");
  NEEDS_DATA(clip);
  constexpr double kBody = 5890;
  for (const auto* from : {"auto", "first:1s"}) {
    const auto areas = areas_of(clip, {"--background", from});
    double least = 1e9, most = 0;
    // Coming in takes half a second.
    for (std::size_t k = 60; k < areas.body.size(); ++k) {
      least = std::min(least, areas.body[k] / kBody);
      most = std::max(most, areas.body[k] / kBody);
    }
    char figure[96];
    std::snprintf(figure, sizeof figure, "%.0f to %.0f %%", 100 * least, 100 * most);
    EXPECT_GE(least, 0.95);
    EXPECT_LE(most, 1.05);
    const auto what = std::string("body over its true area, before furniture, background ") + from;
    row(what.c_str(), figure);
  }
}

// Lines of two moments in one frame; the moving body's outline is a comb.
TEST_F(RealPictures, AnInterlacedFilm) {
  const auto clip = needed("cases/inter.mp4");
  NEEDS_DATA(clip);
  const auto areas = areas_of(clip);
  char figure[64];
  std::snprintf(figure, sizeof figure, "%.2f %%", areas.mean_percent(0));
  row("of the picture that is body in an interlaced film", figure);
  EXPECT_NEAR(areas.mean_percent(0), 3.98, 0.1) << "5.09 % with both fields in one picture, which is 28 % too large";
}

}  // namespace
}  // namespace choreo::test
