// SPDX-License-Identifier: Apache-2.0
// The person network that users have, on the synthetic performer; skipped where script/run could not bring it.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "devices/registry.hpp"
#include "devices/synthetic/performer.hpp"
#include "devices/video_file/video_file.hpp"
#include "pipeline/model_file.hpp"
#include "pipeline/person_models.hpp"
#include "support/outlines.hpp"
#include "support/shared_data.hpp"
#include "vision/network/network.hpp"
#include "vision/network/tflite_reader.hpp"
#include "vision/plain_network.hpp"

namespace choreo::pipeline {
namespace {

using devices::synthetic::Performer;
using devices::synthetic::PerformerSettings;

std::ptrdiff_t threads() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/task"), std::filesystem::directory_iterator());
}

class PersonRecall : public ::testing::TestWithParam<bool> {};

// Every operation as its definition has it, in double precision: the whole network, once.
TEST(PersonNetworkAsDelivered, IsComputedAsItsOperationsAreDefined) {
  const auto missing = missing_person_models({"", true});
  if (!missing.empty()) GTEST_SKIP() << "there is no " << missing << ": script/run brings it";
  const auto bytes = bytes_of_model(usual_models_folder() + "/" + kPersonModels[1].file, 1U << 26U, "a network", "");
  const auto graph = vision::read_tflite({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  PerformerSettings settings;
  settings.size = {256, 256};
  settings.empty = 0;
  const auto picture = Performer("dancing", settings).perform(40).bgr;
  const auto threads_before = threads();
  vision::Network network(graph);
  const auto input = network.input();
  for (std::size_t k = 0; k < input.size(); ++k) {
    input[k] = float(picture.ptr<std::uint8_t>()[3 * (k / 3) + 2 - k % 3]) / 255;
  }
  network.run();
  EXPECT_EQ(threads(), threads_before) << "threads of OpenMP stand still for each other on a busy machine";
  const auto defined = test::evaluate(graph, input);
  ASSERT_EQ(network.outputs(), defined.size());
  for (std::size_t k = 0; k < defined.size(); ++k) {
    double apart = 0, largest = 0;
    for (std::size_t i = 0; i < defined[k].size(); ++i) {
      apart = std::max(apart, std::abs(double(network.output(k)[i]) - defined[k][i]));
      largest = std::max(largest, std::abs(defined[k][i]));
    }
    EXPECT_LT(apart, 1e-4 * std::max(1.0, largest)) << "output " << k;
  }
}

TEST_P(PersonRecall, TheSilhouetteIsThePerformersAndNobodyIsInTheEmptyRoom) {
  const PersonModelOptions options{"", GetParam()};
  const auto missing = missing_person_models(options);
  if (!missing.empty()) GTEST_SKIP() << "there is no " << missing << ": script/run brings it";
  auto search = load_person_search(options);
  double sum = 0, worst = 1;
  int seen = 0, bodies = 0;
  for (const auto* script : {"side-kicks", "dancing", "walking", "jumping-jacks"}) {
    PerformerSettings settings;
    settings.size = {640, 480};
    const Performer performer(script, settings);
    vision::PersonTrack track;
    EXPECT_FALSE(search.search(performer.perform(0).bgr, track.next())) << script;
    for (int i = performer.first_frame() + 10; i < performer.frame_count() && i < performer.first_frame() + 90;
         i += 5) {
      const auto truth = performer.perform(i);
      const cv::Mat body = truth.mask >= 128;
      if (cv::countNonZero(body) < 0.03 * double(body.total())) continue;  // Still coming in.
      ++bodies;
      const auto look = search.search(truth.bgr, track.next());
      track.update(look);
      if (!look) continue;
      ++seen;
      const cv::Mat mask = vision::silhouette_in_picture(*look, body.size()) > 127;
      const double iou = double(cv::countNonZero(mask & body)) / double(cv::countNonZero(mask | body));
      sum += iou;
      worst = std::min(worst, iou);
    }
  }
  std::printf("%s network: seen in %d of %d, silhouettes IoU %.3f, worst %.3f\n", GetParam() ? "lite" : "full", seen,
              bodies, sum / seen, worst);
  EXPECT_EQ(seen, bodies);
  EXPECT_GT(bodies, 40);
  EXPECT_GT(sum / seen, 0.95);
}

// Somebody's silhouettes against outlines that were drawn by hand before any mask was looked at (tests/data/outlines).
TEST_P(PersonRecall, TheSilhouettesOfPeopleMeetOutlinesByHand) {
  const PersonModelOptions options{"", GetParam()};
  const auto missing = missing_person_models(options);
  if (!missing.empty()) GTEST_SKIP() << "there is no " << missing << ": script/run brings it";
  auto search = load_person_search(options);
  for (const auto* name : {"intel_one_by_one.json", "pose2sim_cam01.json", "pose2sim_cam02.json"}) {
    std::ifstream file(test::project_file("tests/data/outlines/") + name);
    const auto outlines = nlohmann::json::parse(file);
    const auto clip = test::shared_data(outlines.at("clip").get<std::string>());
    if (clip.empty()) GTEST_SKIP() << "the recordings in ../shared/data are not here: " << outlines.at("clip");
    std::map<std::uint64_t, cv::Mat> truth;
    for (const auto& frame : outlines.at("frames")) {
      const cv::Size size(outlines.at("size").at(0).get<int>(), outlines.at("size").at(1).get<int>());
      truth[frame.at("frame").get<std::uint64_t>()] = test::filled(frame.at("body"), frame.at("holes"), size);
    }
    devices::Registry registry;
    registry.add(devices::video_file_driver());
    const auto source = registry.open(clip);
    vision::PersonTrack track;
    double sum = 0, worst = 1;
    int met = 0;
    for (std::uint64_t k = 1; met < int(truth.size()); ++k) {
      const auto frame = source->read({});
      ASSERT_TRUE(frame) << name;
      const auto outlined = truth.find(k);
      // As often as the program looks, and at the outlined ones.
      if (outlined == truth.end() && k % std::uint64_t(std::max(1.0, source->info().nominal_fps / 10)) != 0) continue;
      const auto look = search.search(frame->bgr, track.next());
      track.update(look);
      if (outlined == truth.end()) continue;
      ++met;
      double iou = 0;
      if (look) {
        const cv::Mat mask = vision::silhouette_in_picture(*look, frame->bgr.size()) > 127;
        iou = double(cv::countNonZero(mask & outlined->second)) / double(cv::countNonZero(mask | outlined->second));
      }
      std::printf("%s network, %s frame %d: IoU %.3f\n", GetParam() ? "lite" : "full", name, int(k), iou);
      sum += iou;
      worst = std::min(worst, iou);
    }
    std::printf("%s network, %s: mean IoU %.3f, worst %.3f\n", GetParam() ? "lite" : "full", name, sum / met, worst);
    EXPECT_GT(sum / met, 0.8) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(Networks, PersonRecall, ::testing::Bool(),
                         [](const auto& each) { return each.param ? "lite" : "full"; });

}  // namespace
}  // namespace choreo::pipeline
