// SPDX-License-Identifier: Apache-2.0
// A performer who never leaves: the wall is pieced together, and what was never seen is known to be so.
#include "vision/unseen_wall.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <opencv2/core.hpp>

#include "support/drawn_masks.hpp"
#include "vision/body_masker.hpp"
#include "vision/scenes.hpp"

namespace choreo::vision {
namespace {

using test::figure_mask;
using test::iou;
using test::kRed;
using test::same_bytes;
using test::textured_wall;

const cv::Size kUnseenSize(160, 120);

/// Sways by 8 pixels and beckons, in front of the same wall all the time.
cv::Mat hidden_body_at(int k) {
  const int x = 80 + static_cast<int>(std::lround(8 * std::sin(k * 0.7)));
  cv::Mat body = figure_mask(kUnseenSize, {x, 60}, 100);
  body(cv::Rect(k % 2 == 0 ? x + 10 : x - 40, 25 + 9 * (k % 5), 30, 7)) = 255;
  return body;
}

cv::Mat picture_at(int k) {
  return test::with_noise(test::with_body(textured_wall(kUnseenSize), hidden_body_at(k), kRed), 2, std::uint64_t(k));
}

std::vector<cv::Mat> pictures(int count) {
  std::vector<cv::Mat> all;
  for (int k = 0; k < count; ++k) all.push_back(picture_at(k));
  return all;
}

TEST(InferWall, WhatTheBodyAlwaysCoversIsUnseenAndTheRestIsTheWall) {
  const auto wall = infer_wall(pictures(40), 2);
  cv::Mat always(kUnseenSize, CV_8UC1, cv::Scalar(255));
  for (int k = 0; k < 40; ++k) always &= hidden_body_at(k);
  EXPECT_GT(iou(wall.unseen, always), 0.85);
  EXPECT_LT(test::mean_difference(wall.plate, textured_wall(kUnseenSize)), 2.0);
}

TEST(InferWall, PicturesInWhichNothingMovesSayNothing) {
  const std::vector<cv::Mat> still(10, textured_wall(kUnseenSize));
  const auto wall = infer_wall(still, 1);
  EXPECT_EQ(cv::countNonZero(wall.unseen), 0);
  EXPECT_TRUE(same_bytes(wall.plate, textured_wall(kUnseenSize)));
}

TEST(InferWall, OneThreadGivesTheSameBytesAsMany) {
  const auto all = pictures(20);
  const auto many = infer_wall(all, 2);
  const tbb::global_control single(tbb::global_control::max_allowed_parallelism, 1);
  const auto one = infer_wall(all, 2);
  EXPECT_TRUE(same_bytes(one.plate, many.plate));
  EXPECT_TRUE(same_bytes(one.unseen, many.unseen));
}

TEST(BodyMasker, ABodyThatStoodThereFromTheFirstFrameIsWholeAfterSomeSeconds) {
  std::vector<cv::Mat> first(6, picture_at(0));
  auto estimate = judge_plate(median_plate(first), first);
  estimate.provisional = true;
  BodyMasker masker(estimate, {});
  double sum = 0;
  int inferred = 0;
  for (int k = 0; k < 100; ++k) {
    const auto result = masker.process(picture_at(k), k / 10.0);
    if (k < 80) continue;
    sum += iou(result.mask, hidden_body_at(k));
    inferred += result.inferred;
  }
  EXPECT_GT(sum / 20, 0.90);
  EXPECT_GT(inferred, 0) << "and says that it was inferred";
}

TEST(BodyMasker, WithoutInferenceTheSameBodyHasAHole) {
  std::vector<cv::Mat> first(6, picture_at(0));
  auto estimate = judge_plate(median_plate(first), first);
  estimate.provisional = true;
  MaskOptions options;
  options.infer_unseen = false;
  BodyMasker masker(estimate, options);
  MaskResult last;
  for (int k = 0; k < 100; ++k) last = masker.process(picture_at(k), k / 10.0);
  EXPECT_LT(iou(last.mask, hidden_body_at(99)), 0.7);
  EXPECT_EQ(last.inferred, 0);
}

}  // namespace
}  // namespace choreo::vision
