// SPDX-License-Identifier: Apache-2.0
// Recordings of people that nobody here made: whether everything works on them, and how good the silhouettes are.
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "end_to_end/choreoscope_run.hpp"
#include "support/long_lane.hpp"
#include "support/outlines.hpp"
#include "support/places.hpp"
#include "support/shared_data.hpp"

namespace choreo::test {
namespace {

constexpr double kLeastOverlap = 0.85;

#define NEEDS(path)                                                     \
  if ((path).empty())                                                   \
  GTEST_SKIP() << "the recordings in ../shared/data are not here; see " \
                  "tests/support/shared_data.hpp"

nlohmann::json outlines_of(const std::string& name) {
  std::ifstream file(project_file("tests/data/outlines/") + name);
  auto outlines = nlohmann::json::parse(file);
  EXPECT_EQ(outlines.at("frames").size(), 6U);
  return outlines;
}

// Analyses a clip with its masks, however long that takes.
Outcome analyze_patiently(const std::string& clip, const std::string& out, std::vector<std::string> more = {}) {
  RunOptions patient;
  patient.limit = std::chrono::minutes(8);
  more.insert(more.end(), {"--save", "masks"});
  return analyze_with_network(clip, out, more, patient);
}

double overlap_of(const cv::Mat& found, const cv::Mat& truth) {
  return double(cv::countNonZero(found & truth)) / double(cv::countNonZero(found | truth));
}

TEST(Recordings, OutlinesByHandAreMetAndTheEmptyRoomIsEmpty) {
  const auto outlines = outlines_of("intel_one_by_one.json");
  const auto clip = shared_data(outlines.at("clip").get<std::string>());
  NEEDS(clip);
  const TempFolder folder;
  (void)analyze_patiently(clip, folder / "out");
  const cv::Size size(outlines.at("size").at(0).get<int>(), outlines.at("size").at(1).get<int>());
  const auto mask_of = [&](std::size_t frame) {  // Counted from 1; all of them are half a gigabyte.
    const auto one = read_npy(folder / "out/masks.npy", frame - 1, 1);
    EXPECT_EQ(one.data.size(), std::size_t(size.area()));
    return cv::Mat(cv::Mat(size, CV_8UC1, const_cast<std::uint8_t*>(one.data.data())) != 0);
  };
  for (const auto& frame : outlines.at("frames")) {
    const auto truth = filled(frame.at("body"), frame.at("holes"), size);
    const auto found = mask_of(frame.at("frame").get<std::size_t>());
    const double overlap = overlap_of(found, truth);
    std::printf("frame %d: intersection over union %.3f\n", frame.at("frame").get<int>(), overlap);
    EXPECT_GE(overlap, kLeastOverlap) << "frame " << frame.at("frame");
  }
  ASSERT_FALSE(outlines.at("empty").empty());
  for (const auto& stretch : outlines.at("empty")) {
    for (auto frame = stretch.at(0).get<std::size_t>(); frame <= stretch.at(1).get<std::size_t>(); ++frame) {
      EXPECT_EQ(cv::countNonZero(mask_of(frame)), 0) << "somebody in the empty room, frame " << frame;
    }
  }
}

// Outlines are in pixels of the full frame, masks at the working resolution.
class NeverLeaves : public ::testing::TestWithParam<const char*> {};

TEST_P(NeverLeaves, OutlinesByHandAreMetThoughTheWallBehindWasNeverSeen) {
  if (const auto missing = missing_person_network(); !missing.empty()) GTEST_SKIP() << missing << " is not here";
  const auto outlines = outlines_of(GetParam());
  const auto clip = shared_data(outlines.at("clip").get<std::string>());
  NEEDS(clip);
  const TempFolder folder;
  const auto run = analyze_patiently(clip, folder / "out");
  const cv::Size full(outlines.at("size").at(0).get<int>(), outlines.at("size").at(1).get<int>());
  const cv::Size working(270, 480);
  double sum = 0;
  for (const auto& frame : outlines.at("frames")) {
    cv::Mat truth;
    cv::resize(filled(frame.at("body"), frame.at("holes"), full), truth, working, 0, 0, cv::INTER_AREA);
    truth = truth >= 128;
    const auto one = read_npy(folder / "out/masks.npy", frame.at("frame").get<std::size_t>() - 1, 1);
    ASSERT_EQ(one.data.size(), std::size_t(working.area()));
    const cv::Mat found = cv::Mat(working, CV_8UC1, const_cast<std::uint8_t*>(one.data.data())) != 0;
    const double overlap = overlap_of(found, truth);
    std::printf("%s frame %d: intersection over union %.3f\n", GetParam(), frame.at("frame").get<int>(), overlap);
    EXPECT_GE(overlap, kLeastOverlap) << "frame " << frame.at("frame");
    sum += overlap;
  }
  EXPECT_GE(sum / 6, kLeastOverlap);
  const Results results(folder / "out");
  EXPECT_EQ(results.n, 100U);
  EXPECT_EQ(results.summary.at("frames_without_body"), 0);
  EXPECT_GT(std::filesystem::file_size(folder / "out/plot.png"), 10'000U);
  // The result must not look as if it were sure of itself.
  EXPECT_GT(results.summary.at("background").at("share_of_body_inferred"), 0.1);
  EXPECT_EQ(results.summary.at("background").at("uncertain"), true);
  EXPECT_FALSE(run.err_lines("choreoscope: warning: the background is uncertain").empty());
}

// The same outlines by the person network, which needs no empty room.
class MasksOfPeople : public ::testing::TestWithParam<const char*> {};

TEST_P(MasksOfPeople, MeetOutlinesByHand) {
  const auto outlines = outlines_of(GetParam());
  const auto clip = shared_data(outlines.at("clip").get<std::string>());
  NEEDS(clip);
  const auto missing = missing_person_network();
  if (!missing.empty()) GTEST_SKIP() << "there is no " << missing << ": script/run brings it";
  const TempFolder folder;
  (void)analyze_patiently(clip, folder / "out", {"--set", "segmentation=person"});
  const cv::Size full(outlines.at("size").at(0).get<int>(), outlines.at("size").at(1).get<int>());
  double sum = 0;
  for (const auto& frame : outlines.at("frames")) {
    const auto one = read_npy(folder / "out/masks.npy", frame.at("frame").get<std::size_t>() - 1, 1);
    const cv::Size working(int(one.shape.at(2)), int(one.shape.at(1)));
    cv::Mat truth;
    cv::resize(filled(frame.at("body"), frame.at("holes"), full), truth, working, 0, 0, cv::INTER_AREA);
    truth = truth >= 128;
    const cv::Mat found = cv::Mat(working, CV_8UC1, const_cast<std::uint8_t*>(one.data.data())) != 0;
    const double overlap = overlap_of(found, truth);
    std::printf("%s frame %d, by the network: intersection over union %.3f\n", GetParam(), frame.at("frame").get<int>(),
                overlap);
    sum += overlap;
  }
  std::printf("%s, by the network: mean %.3f\n", GetParam(), sum / 6);
  EXPECT_GE(sum / 6, kLeastOverlap);
}

INSTANTIATE_TEST_SUITE_P(Outlines, MasksOfPeople,
                         ::testing::ValuesIn(some_of<const char*>(
                             {"pose2sim_cam01.json", "intel_one_by_one.json", "pose2sim_cam02.json"}, 2)));

INSTANTIATE_TEST_SUITE_P(Pose2Sim, NeverLeaves, ::testing::Values("pose2sim_cam01.json", "pose2sim_cam02.json"));

}  // namespace
}  // namespace choreo::test
