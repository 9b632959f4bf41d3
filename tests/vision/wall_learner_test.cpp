// SPDX-License-Identifier: Apache-2.0
#include "vision/wall_learner.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "support/drawn_masks.hpp"
#include "vision/scenes.hpp"

namespace choreo::vision {
namespace {

using test::same_bytes;

const cv::Size kLearnedSize(80, 60);
constexpr double kFps = 30;

/// Sways before the same wall all the time.
cv::Mat learner_picture_at(int k) {
  const int x = 40 + static_cast<int>(std::lround(6 * std::sin(k * 0.11)));
  const auto body = test::figure_mask(kLearnedSize, {x, 30}, 50);
  return test::with_noise(test::with_body(test::textured_wall(kLearnedSize), body, cv::Scalar(40, 50, 190)), 2,
                          std::uint64_t(k));
}

struct Answer {
  int frame;
  InferredWall wall;
};

/// What it answers to the frames from `begin` to before `end`.
std::vector<Answer> answers(WallLearner& learner, int begin, int end) {
  std::vector<Answer> all;
  for (int k = begin; k < end; ++k) {
    if (auto wall = learner.add(learner_picture_at(k), k / kFps, test::textured_wall(kLearnedSize), {})) {
      all.push_back({k, std::move(*wall)});
    }
  }
  return all;
}

TEST(WallLearner, AnswersSoonAfterTwoSecondsAndThenEverMoreRarely) {
  WallLearner learner(2);
  const auto all = answers(learner, 0, 900);
  ASSERT_GE(all.size(), 4U);
  EXPECT_GE(all[0].frame, 60);
  EXPECT_LE(all[0].frame, 100);
  for (std::size_t i = 2; i < all.size(); ++i) {
    EXPECT_GT(all[i].frame - all[i - 1].frame, all[i - 1].frame - all[i - 2].frame) << i;
  }
}

TEST(WallLearner, NeverWaitsLongerThanTwentySecondsToAskAgain) {
  WallLearner learner(2);
  const auto all = answers(learner, 0, 3000);
  ASSERT_FALSE(all.empty());
  EXPECT_GT(all.back().frame, 3000 - (20 * int(kFps) + 40)) << "it still asks";
  for (std::size_t i = 1; i < all.size(); ++i) EXPECT_LE(all[i].frame - all[i - 1].frame, 20 * kFps + 40) << i;
}

TEST(WallLearner, TheSameFramesGiveTheSameAnswersAtTheSameFrames) {
  WallLearner one(2);
  WallLearner other(2);
  const auto a = answers(one, 0, 200);
  const auto b = answers(other, 0, 200);
  ASSERT_FALSE(a.empty());
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].frame, b[i].frame);
    EXPECT_TRUE(same_bytes(a[i].wall.plate, b[i].wall.plate));
    EXPECT_TRUE(same_bytes(a[i].wall.unseen, b[i].wall.unseen));
  }
}

TEST(WallLearner, AfterAResetItIsAsNew) {
  WallLearner used(2);
  (void)answers(used, 500, 575);  // In the middle of a question.
  used.reset();
  WallLearner fresh(2);
  const auto a = answers(used, 0, 120);
  const auto b = answers(fresh, 0, 120);
  ASSERT_EQ(a.size(), b.size());
  ASSERT_FALSE(a.empty());
  EXPECT_EQ(a[0].frame, b[0].frame);
  EXPECT_TRUE(same_bytes(a[0].wall.plate, b[0].wall.plate));
}

// A thing stands there for most of the time, but not in the last minute.
TEST(WallLearner, ForgetsWhatIsOlderThanAMinute) {
  constexpr int kPerSecond = 10;
  constexpr int kCarriedAway_s = 70;
  const cv::Rect thing(2, 2, 12, 12);
  WallLearner learner(2);
  std::optional<InferredWall> before, after;
  for (int k = 0; k < 132 * kPerSecond; ++k) {
    const bool there = k < kCarriedAway_s * kPerSecond;
    auto picture = learner_picture_at(k);
    if (there) picture(thing).setTo(cv::Scalar(250, 250, 20));
    if (auto wall = learner.add(picture, double(k) / kPerSecond, test::textured_wall(kLearnedSize), {})) {
      (there ? before : after) = std::move(wall);
    }
  }
  ASSERT_TRUE(before && after);
  EXPECT_GT(test::mean_difference(before->plate(thing), test::textured_wall(kLearnedSize)(thing)), 50);
  EXPECT_LT(test::mean_difference(after->plate(thing), test::textured_wall(kLearnedSize)(thing)), 3);
}

}  // namespace
}  // namespace choreo::vision
