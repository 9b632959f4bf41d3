// SPDX-License-Identifier: Apache-2.0
// One mask of colour and depth: who decides where, and what becomes of frames without depth.
#include "vision/segmenter.hpp"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "support/frames.hpp"
#include "vision/scenes.hpp"

namespace choreo::vision {
namespace {

using test::same_pixels;

const cv::Size kSegmentedSize{160, 120};
const cv::Rect kFigure{60, 30, 40, 60};
const cv::Mat kAllKnown(kSegmentedSize, CV_8UC1, cv::Scalar(255));

cv::Mat segment(cv::Rect where) {
  cv::Mat mask = cv::Mat::zeros(kSegmentedSize, CV_8UC1);
  mask(where) = 255;
  return mask;
}
cv::Mat disc(int radius) { return test::disc_mask(kSegmentedSize, {80, 60}, radius); }

TEST(Combined, WhereTheTwoAgreeItIsWhatBothSay) {
  EXPECT_TRUE(same_pixels(combined(disc(30), disc(30), kAllKnown, 2), disc(30)));
}

TEST(Combined, AlongTheEdgesColourDecides) {
  // Depth is a pixel too wide, or too narrow.
  for (const int off : {-1, 1}) {
    EXPECT_TRUE(same_pixels(combined(disc(30), disc(30 + off), kAllKnown, 2), disc(30))) << off;
  }
}

TEST(Combined, OfClothesLikeTheWallColourDecidesNothing) {
  const cv::Mat nothing = cv::Mat::zeros(kSegmentedSize, CV_8UC1);
  EXPECT_TRUE(same_pixels(combined(nothing, disc(30), kAllKnown, 2), disc(30)));
  // A head whose colour shows, on a trunk whose does not.
  const cv::Mat head = segment({70, 10, 20, 20});
  const cv::Mat body = head | segment({60, 30, 40, 60});
  const cv::Mat mask = combined(head, body, kAllKnown, 2);
  EXPECT_TRUE(same_pixels(mask(cv::Rect(0, 40, 160, 80)), body(cv::Rect(0, 40, 160, 80))));
}

TEST(Combined, AShadowThatColourTakesForBodyIsNone) {
  const cv::Mat shadow = segment({100, 60, 40, 30});
  const cv::Mat mask = combined(segment(kFigure) | shadow, segment(kFigure), kAllKnown, 2);
  EXPECT_TRUE(same_pixels(mask, segment(kFigure)));
}

TEST(Combined, WhereDepthIsUnknownColourAloneDecides) {
  // Dark hair gives no depth.
  const cv::Rect hair(70, 14, 20, 16);
  cv::Mat known = kAllKnown.clone();
  known(hair) = 0;
  const cv::Mat body = segment(kFigure) | segment(hair);
  EXPECT_TRUE(same_pixels(combined(body, segment(kFigure), known, 2), body));
  EXPECT_TRUE(same_pixels(combined(segment(kFigure), segment(kFigure), known, 2), segment(kFigure)));
}

TEST(Combined, IsTheSameInAMirror) {
  const cv::Mat colour = disc(30) | segment({0, 100, 160, 20});
  const cv::Mat depth = test::disc_mask(kSegmentedSize, {83, 60}, 29);
  cv::Mat a, b, back;
  cv::flip(colour, a, 1);
  cv::flip(depth, b, 1);
  cv::flip(combined(a, b, kAllKnown, 3), back, 1);
  EXPECT_TRUE(same_pixels(back, combined(colour, depth, kAllKnown, 3)));
}

cv::Mat wall() { return test::textured_wall(kSegmentedSize); }
cv::Mat far_room() { return {kSegmentedSize, CV_16UC1, cv::Scalar(3000)}; }
cv::Mat picture() { return test::with_body(wall(), segment(kFigure), {30, 20, 180}); }
cv::Mat depth(cv::Rect body = kFigure) {
  auto out = far_room();
  out(body) = 2000;
  return out;
}

DepthMasker depth_masker(const MaskOptions& options = {}) {
  DepthBackground background;
  background.depth_mm = far_room();
  background.spread_mm = cv::Mat(kSegmentedSize, CV_32FC1, cv::Scalar(5));
  return {background, {}, options};
}

TEST(Segmenter, ByColourAloneItIsTheColourMaskToTheLastBit) {
  BodyMasker plain(wall(), 1.0, {});
  Segmenter segmenter(BodyMasker(wall(), 1.0, {}));
  EXPECT_FALSE(segmenter.uses_depth());
  for (int i = 0; i < 5; ++i) {
    const auto noisy = test::with_noise(i == 2 ? wall() : picture(), 2, static_cast<std::uint64_t>(i));
    const auto a = plain.process(noisy, i);
    const auto b = segmenter.process(noisy, depth(), i);
    EXPECT_TRUE(same_pixels(a.mask, b.mask));
    EXPECT_EQ(a.area, b.area);
    EXPECT_EQ(a.body, b.body);
  }
}

TEST(Segmenter, ByDepthAloneThePictureIsNotLookedAt) {
  Segmenter segmenter(std::nullopt, depth_masker(), {});
  EXPECT_TRUE(segmenter.uses_depth());
  const auto result = segmenter.process(cv::Mat(), depth(), 0);
  EXPECT_TRUE(result.body);
  EXPECT_EQ(result.area, cv::countNonZero(result.mask));
  EXPECT_GE(test::iou(result.mask, segment(kFigure)), 0.99);
  EXPECT_FALSE(result.cut);
  EXPECT_TRUE(segmenter.process(cv::Mat(), depth({60, 60, 40, 60}), 1).cut);
}

TEST(Segmenter, ByBothClothesLikeTheWallAreSeenAndTheMaskIsWhole) {
  Segmenter segmenter(BodyMasker(wall(), 1.0, {}), depth_masker(), {});
  const auto result = segmenter.process(wall(), depth(), 0);
  EXPECT_TRUE(result.body);
  EXPECT_GE(test::iou(result.mask, segment(kFigure)), 0.99);
}

TEST(Segmenter, WhatIsTooSmallIsNoBody) {
  MaskOptions options;
  options.min_body_percent = 5;
  Segmenter segmenter(std::nullopt, depth_masker(options), options);
  const auto result = segmenter.process(cv::Mat(), depth({60, 30, 20, 20}), 0);  // 2 %
  EXPECT_FALSE(result.body);
  EXPECT_EQ(result.area, 0);
  EXPECT_EQ(cv::countNonZero(result.mask), 0);
}

TEST(Segmenter, OfTwoPartsTheLargestAloneIsKeptWhereAskedFor) {
  auto both = depth();
  both(cv::Rect(10, 40, 20, 30)) = 2000;
  MaskOptions options;
  Segmenter all(std::nullopt, depth_masker(options), options);
  EXPECT_GT(cv::countNonZero(all.process(cv::Mat(), both, 0).mask(cv::Rect(0, 0, 50, 120))), 500);
  options.largest_only = true;
  Segmenter largest(std::nullopt, depth_masker(options), options);
  EXPECT_GE(test::iou(largest.process(cv::Mat(), both, 0).mask, segment(kFigure)), 0.99);
}

TEST(Segmenter, AFrameWithoutDepthIsDecidedByColourOrHasNoBody) {
  Segmenter both(BodyMasker(wall(), 1.0, {}), depth_masker(), {});
  EXPECT_GE(test::iou(both.process(picture(), cv::Mat(), 0).mask, segment(kFigure)), 0.98);
  Segmenter deep(std::nullopt, depth_masker(), {});
  const auto result = deep.process(picture(), cv::Mat(), 0);
  EXPECT_FALSE(result.body);
  EXPECT_EQ(result.mask.size(), kSegmentedSize);
  EXPECT_EQ(cv::countNonZero(result.mask), 0);
}

TEST(Segmenter, WhileTheRoomsDepthIsLearnedAnewColourDecides) {
  Segmenter both(BodyMasker(wall(), 1.0, {}), depth_masker(), {});
  cv::Mat elsewhere(kSegmentedSize, CV_16UC1, cv::Scalar(2500));
  const auto result = both.process(picture(), elsewhere, 0);
  EXPECT_TRUE(result.sudden);
  EXPECT_GE(test::iou(result.mask, segment(kFigure)), 0.98);
}

TEST(Segmenter, AsItTurnsOutWhateverDiffersIsBodyUntilAPersonWasSeenForAThirdOfASecond) {
  BackgroundEstimate estimate;
  estimate.plate = wall();
  estimate.noise = 1;
  Segmenter segmenter(estimate, {}, false);
  const cv::Rect chair(120, 60, 24, 40);
  auto both = picture();
  both(chair).setTo(cv::Scalar(200, 200, 30));
  PersonEvidence person;
  person.likely = segment(kFigure);
  person.doubt_px = 1;
  EXPECT_NE(cv::countNonZero(segmenter.process(both, {}, 0, {}).mask(chair)), 0);
  // What is no different from the room is no person.
  for (double t = 0.1; t < 1; t += 0.1) (void)segmenter.process(wall(), {}, t, person);
  EXPECT_FALSE(segmenter.of_person());
  EXPECT_FALSE(segmenter.process(wall(), {}, 1, person).of_person);
  for (double t = 1.1; t < 1.4; t += 0.1) {
    EXPECT_NE(cv::countNonZero(segmenter.process(both, {}, t, person).mask(chair)), 0) << t;
  }
  for (double t = 1.4; t < 1.6; t += 0.1) (void)segmenter.process(both, {}, t, person);
  EXPECT_TRUE(segmenter.of_person());
  const auto result = segmenter.process(both, {}, 1.7, person);
  EXPECT_TRUE(result.of_person);
  const auto& mask = result.mask;
  EXPECT_EQ(cv::countNonZero(mask(chair)), 0);
  EXPECT_GT(cv::countNonZero(mask), 0.95 * kFigure.area());
}

TEST(Segmentation, HasThreeNames) {
  EXPECT_EQ(segmentation_named("colour"), Segmentation::kColour);
  EXPECT_EQ(segmentation_named("depth"), Segmentation::kDepth);
  EXPECT_EQ(segmentation_named("both"), Segmentation::kBoth);
}

}  // namespace
}  // namespace choreo::vision
