// SPDX-License-Identifier: Apache-2.0
// The person network that users have, on the synthetic performer; skipped where script/run could not bring it.
#include <cstdio>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "devices/synthetic/performer.hpp"
#include "pipeline/model_file.hpp"
#include "pipeline/person_models.hpp"
#include "vision/network/network.hpp"
#include "vision/network/tflite_reader.hpp"
#include "vision/plain_network.hpp"

namespace choreo::pipeline {
namespace {

using devices::synthetic::Performer;
using devices::synthetic::PerformerSettings;

constexpr int kThreads = 2;

class PersonRecall : public ::testing::TestWithParam<bool> {};

// Every operation as its definition has it, in double precision: the whole network, once.
TEST(PersonNetworkAsDelivered, IsComputedAsItsOperationsAreDefined) {
  const auto missing = missing_person_models({"", true, kThreads});
  if (!missing.empty()) GTEST_SKIP() << "there is no " << missing << ": script/run brings it";
  const auto bytes = bytes_of_model(usual_models_folder() + "/" + kPersonModels[1].file, 1U << 26U, "a network", "");
  const auto graph = vision::read_tflite({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  PerformerSettings settings;
  settings.size = {256, 256};
  settings.empty = 0;
  const auto picture = Performer("dancing", settings).perform(40).bgr;
  vision::Network network(graph, kThreads);
  const auto input = network.input();
  for (std::size_t k = 0; k < input.size(); ++k) {
    input[k] = float(picture.ptr<std::uint8_t>()[3 * (k / 3) + 2 - k % 3]) / 255;
  }
  network.run();
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
  const PersonModelOptions options{"", GetParam(), kThreads};
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

INSTANTIATE_TEST_SUITE_P(Networks, PersonRecall, ::testing::Bool(),
                         [](const auto& each) { return each.param ? "lite" : "full"; });

}  // namespace
}  // namespace choreo::pipeline
