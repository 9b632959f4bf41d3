// SPDX-License-Identifier: Apache-2.0
// What was seen of the empty room is not replaced by what anybody guesses, whoever stands before it and for how long:
// every script of both drawn performers.
#include <functional>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "devices/synthetic/performer.hpp"
#include "support/flat_performer.hpp"
#include "vision/background_estimate.hpp"
#include "vision/body_masker.hpp"
#include "vision/difference.hpp"
#include "vision/person_masker.hpp"

namespace choreo::vision {
namespace {

const cv::Size kSize(160, 120);
constexpr double kFps = 8;
constexpr int kEmpty = 8, kFrames = 56;  // A second, and six of somebody.

struct Scene {
  std::string name;
  std::function<std::pair<cv::Mat, cv::Mat>(int)> frame;  // Picture and body.
};
void PrintTo(const Scene& scene, std::ostream* out) { *out << scene.name; }

std::vector<Scene> all_scenes() {
  std::vector<Scene> scenes;
  for (const auto& script : devices::synthetic::script_names()) {
    if (script == "empty") continue;
    devices::synthetic::PerformerSettings settings;
    settings.size = kSize;
    settings.fps = kFps;
    settings.empty = kEmpty / kFps;
    settings.duration = (kFrames - kEmpty) / kFps;
    const auto performer = std::make_shared<devices::synthetic::Performer>(script, settings);
    scenes.push_back({script, [performer](int k) {
                        auto seen = performer->perform(k);
                        return std::pair(seen.bgr, seen.mask);
                      }});
  }
  for (const auto* script : {"dance", "wave", "stand"}) {
    for (int look = 0; look < 3; ++look) {
      test::FlatScene scene;
      scene.look = look;
      scene.script = script;
      scene.empty_s = kEmpty / kFps;
      scene.size = kSize;
      const auto performer = std::make_shared<test::FlatPerformer>(scene);
      scenes.push_back({"flat " + std::string(script) + " " + std::to_string(look), [performer](int k) {
                          auto seen = performer->frame(k / kFps);
                          return std::pair(seen.picture, cv::Mat(seen.body | seen.held));
                        }});
    }
  }
  return scenes;
}

class WhatWasSeenOfTheRoom : public ::testing::TestWithParam<Scene> {};

TEST_P(WhatWasSeenOfTheRoom, IsKept) {
  std::vector<cv::Mat> empty;
  for (int k = 0; k < kEmpty; ++k) empty.push_back(GetParam().frame(k).first);
  BackgroundEstimate estimate;
  estimate.plate = median_plate(empty);
  estimate.noise = 3;
  BodyMasker by_difference(estimate, {});
  PersonMasker by_people(estimate, {});
  int seen = 0;
  for (int k = kEmpty; k < kFrames; ++k) {
    const auto [picture, body] = GetParam().frame(k);
    seen += cv::countNonZero(body) > 0 ? 1 : 0;
    // The network misses every fourth picture.
    PersonEvidence person;
    if (k % 4 != 0 && cv::countNonZero(body) > 0) person = {body, 2};
    (void)by_difference.process(picture, k / kFps);
    (void)by_people.process(picture, person, k / kFps);
  }
  ASSERT_GT(seen, (kFrames - kEmpty) / 4) << "nobody was there: this proves nothing";
  const auto kept = [&](const cv::Mat& background, double threshold) {
    return cv::countNonZero(difference_luminance(background, estimate.plate) > threshold) == 0;
  };
  EXPECT_TRUE(kept(by_difference.background(), by_difference.threshold()));
  EXPECT_TRUE(kept(by_people.background(), by_people.threshold()));
}

INSTANTIATE_TEST_SUITE_P(EveryScript, WhatWasSeenOfTheRoom, ::testing::ValuesIn(all_scenes()));

}  // namespace
}  // namespace choreo::vision
