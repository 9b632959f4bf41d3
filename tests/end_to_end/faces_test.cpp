// SPDX-License-Identifier: Apache-2.0
// Where the face of a dancer is, by the person network and by the detector alone.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <ostream>
#include <string>

#include <gtest/gtest.h>

#include "devices/source_uri.hpp"
#include "devices/synthetic/synthetic_source.hpp"
#include "end_to_end/choreoscope_run.hpp"

namespace choreo::test {
namespace {

struct FacesFound {
  int seen = 0;       ///< Frames in which the dancer's face is seen.
  int near = 0;       ///< Of them, those in which a face is found no farther than half a face's width from it.
  int elsewhere = 0;  ///< Those in which one is found farther away.
  int in_the_empty_room = 0;
};

FacesFound faces_in(const std::string& csv, const std::string& source) {
  const auto request =
      devices::performer_request(devices::parse_source_uri(source, [](const std::string&) { return false; }));
  const devices::synthetic::Performer performer(request.script, request.settings);
  std::ifstream file(csv);
  std::string line;
  std::getline(file, line);
  EXPECT_EQ(line.rfind("frame,time_s,face_x_px,face_y_px,face_width_px,face_height_px,", 0), 0u) << line;
  FacesFound found;
  for (int k = 0; std::getline(file, line); ++k) {
    double x = 0, y = 0, width = 0, height = 0;
    const bool face = std::sscanf(line.c_str(), "%*d,%*f,%lf,%lf,%lf,%lf", &x, &y, &width, &height) == 4;
    const auto truth = performer.perform(k);
    if (!truth.present && face) ++found.in_the_empty_room;
    if (truth.face.empty()) continue;
    ++found.seen;
    if (!face) continue;
    const cv::Point2d apart = cv::Point2d(x + width / 2, y + height / 2) - (truth.face.tl() + truth.face.br()) / 2;
    ++(std::hypot(apart.x, apart.y) <= truth.face.width / 2 ? found.near : found.elsewhere);
  }
  return found;
}

class FacesOfDancers : public ::testing::TestWithParam<const char*> {};

TEST_P(FacesOfDancers, AreFoundInEveryFrame) {
  if (const auto missing = missing_person_network(); !missing.empty()) GTEST_SKIP() << missing << " is not here";
  const auto source = std::string("synthetic://") + GetParam() + "&size=640x480&fps=30&duration=4&empty=1";
  const TempFolder folder;
  const std::vector<std::string> arguments{"--save", "particles",        "--set", "plot.width_px=320",
                                           "--set",  "plot.thumbnails=0"};
  analyze_with_network(source, folder / "with", arguments);
  const auto with = faces_in(folder / "with" + "/particles.csv", source);
  analyze(source, folder / "without", arguments);
  const auto without = faces_in(folder / "without" + "/particles.csv", source);
  std::printf("| %s | %d of %d, %d elsewhere | %d, %d elsewhere |\n", GetParam(), with.near, with.seen, with.elsewhere,
              without.near, without.elsewhere);
  EXPECT_GT(with.seen, 60);
  EXPECT_GE(with.near, 0.98 * with.seen);
  EXPECT_EQ(with.in_the_empty_room, 0);
}

INSTANTIATE_TEST_SUITE_P(Dances, FacesOfDancers,
                         ::testing::Values("dancing?seed=1", "side-kicks?seed=2", "jumping-jacks?seed=3"));

}  // namespace
}  // namespace choreo::test
