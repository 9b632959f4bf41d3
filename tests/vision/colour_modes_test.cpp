// SPDX-License-Identifier: Apache-2.0
#include "vision/colour_modes.hpp"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <opencv2/core.hpp>

#include "vision/scenes.hpp"

namespace choreo::vision {
namespace {

/// One pixel over time.
ColourModes modes_of(const std::vector<cv::Vec3b>& colours, int radius = 10) {
  std::vector<cv::Mat> pictures;
  for (const auto& c : colours) pictures.emplace_back(1, 1, CV_8UC3, cv::Scalar(c[0], c[1], c[2]));
  return colour_modes(pictures, radius);
}

const cv::Vec3b kWall(100, 110, 120);
const cv::Vec3b kShirt(20, 30, 200);

TEST(ColourModes, APixelThatShowsOneColourHasOneMode) {
  const auto modes = modes_of({kWall, kWall, kWall});
  EXPECT_EQ(modes.pictures, 3);
  EXPECT_EQ(modes.at(0)[0].colour, kWall);
  EXPECT_EQ(modes.at(0)[0].count, 3);
  for (int m = 1; m < ColourModes::kMost; ++m) EXPECT_EQ(modes.at(0)[m].count, 0);
}

TEST(ColourModes, TheCommonestComesFirstAndEachPictureKnowsItsOwn) {
  const auto modes = modes_of({kShirt, kWall, kShirt, kWall, kWall});
  EXPECT_EQ(modes.at(0)[0].colour, kWall);
  EXPECT_EQ(modes.at(0)[0].count, 3);
  EXPECT_EQ(modes.at(0)[1].colour, kShirt);
  EXPECT_EQ(modes.at(0)[1].count, 2);
  const std::vector<int> expected = {1, 0, 1, 0, 0};
  for (std::size_t k = 0; k < expected.size(); ++k) EXPECT_EQ(modes.of[k].data[0], expected[k]) << k;
}

TEST(ColourModes, ColoursWithinTheRadiusAreOneAndItsColourIsTheirMean) {
  const auto modes = modes_of({{100, 100, 100}, {104, 100, 100}, {108, 100, 100}});
  EXPECT_EQ(modes.at(0)[0].count, 3);
  EXPECT_EQ(modes.at(0)[0].colour, cv::Vec3b(104, 100, 100));
}

TEST(ColourModes, TheRadiusIsOfTheGreatestChannel) {
  EXPECT_EQ(modes_of({{100, 100, 100}, {110, 110, 110}}).at(0)[0].count, 2);
  EXPECT_EQ(modes_of({{100, 100, 100}, {100, 111, 100}}).at(0)[0].count, 1);
}

// Six colours, one more than there are places: the rarest so far makes room, and the picture that showed it has none.
TEST(ColourModes, WhereThereAreTooManyTheRarestGoes) {
  std::vector<cv::Vec3b> colours;
  for (const int level : {0, 50, 100, 150, 200}) {
    colours.insert(colours.end(), level == 150 ? 1 : 2, cv::Vec3b::all(uchar(level)));
  }
  colours.push_back(cv::Vec3b::all(250));
  const auto modes = modes_of(colours);
  for (int m = 0; m < ColourModes::kMost; ++m) EXPECT_NE(modes.at(0)[m].colour, cv::Vec3b::all(150));
  EXPECT_EQ(modes.of[6].data[0], ColourModes::kNone);
  EXPECT_NE(modes.of.back().data[0], ColourModes::kNone);
}

TEST(ColourModes, EveryPictureIsCountedOnceOrFitsNone) {
  std::vector<cv::Mat> pictures;
  for (int k = 0; k < 30; ++k) {
    auto picture = test::textured_wall({40, 30});
    if (k % 3 == 0) picture(cv::Rect(k / 3, 5, 12, 20)).setTo(cv::Scalar(20, 30, 200));
    pictures.push_back(test::with_noise(picture, 4, std::uint64_t(k)));
  }
  const auto modes = colour_modes(pictures, 10);
  for (int p = 0; p < 40 * 30; ++p) {
    std::vector<int> seen(ColourModes::kMost, 0);
    for (const auto& of : modes.of) {
      if (of.data[p] != ColourModes::kNone) ++seen.at(of.data[p]);
    }
    for (int m = 0; m < ColourModes::kMost; ++m) ASSERT_EQ(modes.at(p)[m].count, seen[std::size_t(m)]) << p;
  }
}

TEST(ColourModes, OneThreadGivesTheSameAsMany) {
  std::vector<cv::Mat> pictures;
  for (int k = 0; k < 12; ++k) pictures.push_back(test::with_noise(test::textured_wall({64, 48}), 8, std::uint64_t(k)));
  const auto many = colour_modes(pictures, 6);
  const tbb::global_control single(tbb::global_control::max_allowed_parallelism, 1);
  const auto one = colour_modes(pictures, 6);
  ASSERT_EQ(one.modes.size(), many.modes.size());
  EXPECT_TRUE(std::equal(one.modes.begin(), one.modes.end(), many.modes.begin(),
                         [](const auto& a, const auto& b) { return a.colour == b.colour && a.count == b.count; }));
}

}  // namespace
}  // namespace choreo::vision
