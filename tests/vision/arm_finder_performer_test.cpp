// SPDX-License-Identifier: Apache-2.0
// The arms of the synthetic performer in all signs, with an ideal tone: its true skin.
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "devices/synthetic/performer.hpp"
#include "vision/arm_finder.hpp"

namespace choreo::vision {
namespace {

struct Found {
  double mean_error = 0;   // Of the centroids, face widths.
  double worst_clear = 0;  // Where no arm crosses the face.
  int two = 0;
  int signs = 0;
};

Found found(const std::string& sleeves, const std::string& build, double distance) {
  devices::synthetic::PerformerSettings settings;
  settings.size = {480, 360};
  settings.fps = 10;
  settings.empty = 0;
  settings.noise = 0;
  settings.text = "ABCDEFGHIJKLMNOPQRSTUVWXYZ#!";
  settings.letters_per_minute = 60;
  settings.sleeves = sleeves;
  settings.build = build;
  settings.distance = distance;
  const devices::synthetic::Performer performer("semaphore", settings);

  Found result;
  TrackedFace face;
  for (int k = 0; k < int(settings.text.size()); ++k) {
    const auto p = performer.perform(10 * k + 4);  // While the sign is held.
    if (!p.face.empty()) {                         // An arm before it hides it: its track coasts.
      face.centre = {p.face.x + p.face.width / 2, p.face.y + p.face.height / 2};
      face.width = p.face.width;
    }
    cv::Mat tone = p.bare_arm[0] | p.bare_arm[1];
    const cv::Size half(int(0.5 * face.width), int(0.62 * face.width));
    cv::ellipse(tone, face.centre, half, 0, 0, 360, cv::Scalar(255), -1);
    ArmFinder finder;
    const auto arms = finder.find(tone, p.mask, face, 0);
    auto truth = std::array{moments_of(p.bare_arm[0]).centroid, moments_of(p.bare_arm[1]).centroid};
    if (truth[1].x < truth[0].x) std::swap(truth[0], truth[1]);
    ++result.signs;
    if (arms.found == ArmCase::kTwoArms) ++result.two;
    for (std::size_t arm = 0; arm < 2; ++arm) {
      const double error = cv::norm(arms.blob[arm].moments.centroid - truth[arm]) / face.width;
      result.mean_error += error / (2 * double(settings.text.size()));
      if (!arms.at_face) result.worst_clear = std::max(result.worst_clear, error);
    }
  }
  return result;
}

TEST(ArmFinderOnThePerformer, FindsBothForearmsUnderHalfSleeves) {
  const auto result = found("half", "medium", 1);
  EXPECT_EQ(result.two, result.signs);
  EXPECT_LT(result.mean_error, 0.05);
  EXPECT_LT(result.worst_clear, 0.05);
}

TEST(ArmFinderOnThePerformer, FindsBothWholeArmsWithoutSleeves) {
  const auto result = found("none", "stout", 1);
  EXPECT_EQ(result.two, result.signs);
  EXPECT_LT(result.mean_error, 0.05);
  EXPECT_LT(result.worst_clear, 0.05);
}

TEST(ArmFinderOnThePerformer, FindsBothArmsOfASmallFarPerson) {
  const auto result = found("half", "slender", 2);
  EXPECT_EQ(result.two, result.signs);
  EXPECT_LT(result.mean_error, 0.08);
  EXPECT_LT(result.worst_clear, 0.08);
}

}  // namespace
}  // namespace choreo::vision
