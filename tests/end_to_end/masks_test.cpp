// SPDX-License-Identifier: Apache-2.0
// How far the masks of performers agree with the truth.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "end_to_end/mask_truth.hpp"
#include "support/long_lane.hpp"

namespace choreo::test {
namespace {

class MasksOfSeed : public ::testing::TestWithParam<int> {};

TEST_P(MasksOfSeed, AgreeWithTheTruthAt320x240) {
  // Another script, body, skin, clothes, room and noise with every seed.
  static const std::vector<std::string> scripts{"jumping-jacks", "walking", "side-kicks", "idle",
                                                "stillness",     "limp",    "semaphore",  "palindrome"};
  const auto seed = GetParam();
  const auto& script = scripts[static_cast<std::size_t>(seed) % scripts.size()];
  EXPECT_GE(mean_iou("synthetic://" + script + "?size=320x240&fps=15&duration=5&seed=" + std::to_string(seed)), 0.97);
}

INSTANTIATE_TEST_SUITE_P(Seeds, MasksOfSeed, ::testing::ValuesIn(some_of<int>({1, 2, 3, 4, 5, 6, 7, 8, 9, 10}, 4)));

class MasksOfWhoNeverLeaves : public ::testing::TestWithParam<const char*> {};

TEST_P(MasksOfWhoNeverLeaves, AreWholeThoughTheWallBehindWasNeverSeen) {
  if (const auto missing = missing_person_network(); !missing.empty()) GTEST_SKIP() << missing << " is not here";
  EXPECT_GE(mean_iou(std::string("synthetic://") + GetParam() + "&size=320x240&fps=15&duration=6&empty=0"), 0.90);
}

INSTANTIATE_TEST_SUITE_P(Clips, MasksOfWhoNeverLeaves,
                         ::testing::ValuesIn(some_of<const char*>(
                             {"jumping-jacks?seed=1", "side-kicks?seed=2", "semaphore?seed=3", "palindrome?seed=4",
                              "limp?seed=5", "idle?seed=6", "jumping-jacks?seed=7", "side-kicks?seed=8",
                              "anti-palindrome?seed=11", "idle?seed=12", "jumping-jacks?seed=1&clothes=near-wall",
                              "side-kicks?seed=2&clothes=near-wall", "limp?seed=5&clothes=near-wall"},
                             4)));

class LiveMasksOfWhoNeverLeaves : public ::testing::TestWithParam<const char*> {};

TEST_P(LiveMasksOfWhoNeverLeaves, AreWholeAfterAFewSeconds) {
  if (const auto missing = missing_person_network(); !missing.empty()) GTEST_SKIP() << missing << " is not here";
  // As live works: the median of the first two seconds, what comes to light later, and 120 rows.
  EXPECT_GE(mean_iou(std::string("synthetic://") + GetParam() + "&size=320x240&fps=30&duration=12&empty=0",
                     {"--background", "first:2s", "--set", "working.rows=120"}, 8),
            0.90);
}

INSTANTIATE_TEST_SUITE_P(Clips, LiveMasksOfWhoNeverLeaves,
                         ::testing::ValuesIn(some_of<const char*>(
                             {"jumping-jacks?seed=1", "jumping-jacks?seed=7", "side-kicks?seed=2", "limp?seed=5",
                              "side-kicks?seed=2&clothes=near-wall", "limp?seed=5&clothes=near-wall"},
                             2)));

TEST(Masks, AgreeWithTheTruthAtFullHd) {
  EXPECT_GE(mean_iou("synthetic://side-kicks?size=1920x1080&fps=10&duration=3&empty=0.5&seed=5"), 0.97);
}

// A plain shirt of the wall's hue is no shadow on it.
TEST(Masks, OfClothesNearTheWallsColourAreWholeBeforeAWallThatWasSeen) {
  EXPECT_GE(mean_iou("synthetic://side-kicks?size=320x240&fps=10&duration=4&empty=1&seed=2&clothes=near-wall"), 0.97);
}

TEST(Masks, NobodyIsSeenInAnEmptyRoomBeforeAndAfter) {
  EXPECT_GE(mean_iou("synthetic://walking?size=320x240&fps=15&duration=3&empty=1&tail=1&seed=11&flicker=4&drift=30"),
            0.95);
  EXPECT_GE(mean_iou("synthetic://crossing?size=320x240&fps=10&seed=12"), 0.95);
}

TEST(Masks, OfACameraThatShakesAreAsGood) {
  const std::string shaken = "synthetic://jumping-jacks?size=320x240&fps=15&duration=2&empty=1&seed=7&shake=6";
  const auto by_colour = mask_figures(shaken, {"--set", "segmentation=colour"});
  EXPECT_GE(by_colour.mean_iou, 0.97);
  EXPECT_EQ(by_colour.summary.at("background").at("camera_shakes"), true);
  EXPECT_LT(by_colour.summary.at("background").at("share_of_frames_in_which_the_camera_moved"), 0.1);
  if (const auto missing = missing_person_network(); !missing.empty()) GTEST_SKIP() << missing << " is not here";
  EXPECT_GE(mean_iou(shaken), 0.97);
}

// The table of docs/accuracy.md: what the person network decides, what it costs, and what is made without it.
TEST(Masks, WithTheNetworkAndWithoutIt) {
  if (!in_long_lane()) GTEST_SKIP() << "a measurement for script/test --long";
  if (const auto missing = missing_person_network(); !missing.empty()) GTEST_SKIP() << missing << " is not here";
  for (const auto* clip :
       {"jumping-jacks?seed=1&empty=1", "side-kicks?seed=2&empty=1&clothes=near-wall", "jumping-jacks?seed=1&empty=0",
        "semaphore?seed=3&empty=0", "side-kicks?seed=2&empty=0&clothes=near-wall", "idle?seed=12&empty=0"}) {
    const auto source = std::string("synthetic://") + clip + "&size=640x480&fps=15&duration=6";
    const auto with = mask_figures(source);
    const auto without = mask_figures(source, {"--set", "segmentation=colour"});
    const auto ms = [](const nlohmann::json& summary) {
      const auto& timings = summary.at("timings");
      return 1e3 * (timings.at("learn_background_s").get<double>() + timings.at("frames_s").get<double>()) /
             summary.at("frames").get<double>();
    };
    std::printf("| %s | %.3f | %.3f | %.0f %% | %.0f ms | %.0f ms |\n", clip, with.mean_iou, without.mean_iou,
                100 * with.summary.at("background").at("share_of_body_inferred").get<double>(), ms(with.summary),
                ms(without.summary));
    EXPECT_GE(with.mean_iou, 0.97) << clip;
    EXPECT_GE(with.mean_iou, without.mean_iou - 0.005) << clip;
  }
}

}  // namespace
}  // namespace choreo::test
