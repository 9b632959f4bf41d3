// SPDX-License-Identifier: Apache-2.0
#include "recognition/sign_cover.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "body/semaphore_signs.hpp"

namespace choreo::recognition {
namespace {

const cv::Point2d kFace(300, 260);
constexpr double kWidth = 40;

/// The two bare forearms of a sign as strokes, each `off` degrees beside its direction.
cv::Mat forearms(const body::SemaphoreSign& sign, double off = 0) {
  cv::Mat out = cv::Mat::zeros(600, 600, CV_8UC1);
  const auto draw = [&](double side, int position, double degrees) {
    const double angle = (position * 45 + degrees) * std::numbers::pi / 180;
    const cv::Point2d along(-std::sin(angle), std::cos(angle));
    const cv::Point2d shoulder = kFace + cv::Point2d(side * 1.25, 1.17) * kWidth;
    cv::line(out, shoulder + along * (1.3 * kWidth), shoulder + along * (3.6 * kWidth), 255, 18);
  };
  draw(1, sign.left, off);
  draw(-1, sign.right, -off);
  return out;
}

std::string_view best_of(const SignCoverage& coverage) {
  const auto best = std::max_element(coverage.overlap.begin(), coverage.overlap.end());
  return body::semaphore_signs()[std::size_t(best - coverage.overlap.begin())].name;
}

TEST(SignCover, EverySignIsCoveredBestByItself) {
  const SignCover signs;
  for (const auto& sign : body::semaphore_signs()) {
    for (const double off : {0.0, 12.0, -12.0}) {
      const auto coverage = signs.cover(forearms(sign, off), kFace, kWidth);
      EXPECT_EQ(best_of(coverage), sign.name) << off;
      EXPECT_GT(*std::max_element(coverage.overlap.begin(), coverage.overlap.end()), 0.6) << sign.name << off;
    }
  }
}

TEST(SignCover, AFaceThatIsTakenForTooLargeOrTooSmallDoesNotMatter) {
  const SignCover signs;
  for (const auto& sign : body::semaphore_signs()) {
    for (const double factor : {0.87, 1.15}) {
      EXPECT_EQ(best_of(signs.cover(forearms(sign), kFace, kWidth * factor)), sign.name) << factor;
    }
  }
}

TEST(SignCover, AMirroredPictureShowsTheSameSign) {
  const SignCover signs(SignCoverOptions{.mirrored = true});
  for (const auto* name : {"A", "K", "P", "Z"}) {
    cv::Mat mirror;
    cv::flip(forearms(body::semaphore(name).value()), mirror, 1);
    EXPECT_EQ(best_of(signs.cover(mirror, {599 - kFace.x, kFace.y}, kWidth)), name);
  }
}

TEST(SignCover, TwoBarsOnOneArmAreNotTwoArms) {
  const SignCover signs;
  int asked = 0;
  for (const auto& sign : body::semaphore_signs()) {
    if (sign.left == 0 || sign.right != 0) continue;
    ++asked;
    // One arm alone: no sign explains more than that arm.
    auto one = forearms(sign);
    one(cv::Rect(0, 0, 300, 600)).setTo(0);
    const auto coverage = signs.cover(one, kFace, kWidth);
    EXPECT_LT(*std::max_element(coverage.overlap.begin(), coverage.overlap.end()), 0.85) << sign.name;
    EXPECT_EQ(best_of(signs.cover(one, kFace, kWidth, true)), sign.name);
  }
  EXPECT_GT(asked, 0);
}

TEST(SignCover, FlagsBeyondTheHandsAreCoveredWhereArmsAreSaidToReachSoFar) {
  SignCoverOptions flags;
  flags.reach = 6;
  flags.typical_arm = 4;
  const SignCover bare, with_flags(flags);
  for (const auto* name : {"C", "H", "M", "R", "U", "Y"}) {
    const auto sign = body::semaphore(name).value();
    cv::Mat picture = cv::Mat::zeros(600, 600, CV_8UC1);
    for (const auto& [side, position] : {std::pair(1.0, sign.left), {-1.0, sign.right}}) {
      const double angle = position * std::numbers::pi / 4;
      const cv::Point2d along(-std::sin(angle), std::cos(angle));
      const cv::Point2d shoulder = kFace + cv::Point2d(side * 1.25, 1.17) * kWidth;
      const cv::RotatedRect cloth(shoulder + along * (3.9 * kWidth), cv::Size2d(1.7 * kWidth, 1.7 * kWidth),
                                  float(position * 45));
      cv::Point2f corners[4];
      cloth.points(corners);
      const std::vector<cv::Point> outline(std::begin(corners), std::end(corners));
      cv::fillConvexPoly(picture, outline, 255);
    }
    const auto coverage = with_flags.cover(picture, kFace, kWidth);
    const auto most = *std::max_element(coverage.overlap.begin(), coverage.overlap.end());
    EXPECT_EQ(best_of(coverage), name);
    EXPECT_GT(most, 0.7) << name;
    const auto by_arms = bare.cover(picture, kFace, kWidth);
    EXPECT_LT(*std::max_element(by_arms.overlap.begin(), by_arms.overlap.end()), most) << name;
  }
}

TEST(SignCover, NothingSeenIsNothingCovered) {
  const auto coverage = SignCover().cover(cv::Mat::zeros(600, 600, CV_8UC1), kFace, kWidth);
  EXPECT_EQ(*std::max_element(coverage.overlap.begin(), coverage.overlap.end()), 0);
  EXPECT_EQ(coverage.seen, 0);
}

}  // namespace
}  // namespace choreo::recognition
