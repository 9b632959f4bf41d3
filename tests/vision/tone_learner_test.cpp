// SPDX-License-Identifier: Apache-2.0
#include "vision/tone_learner.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "core/error.hpp"

namespace choreo::vision {
namespace {

using ::testing::HasSubstr;

const cv::Scalar kPortraitSkin(142, 178, 226);  // Blue green red.
const cv::Scalar kPortraitShirt(132, 66, 36);
const TrackedFace kPortraitFace{{160, 60}, 36, 1, 0, 0};

// A face with eyes, brows, mouth and hair over a shirt, before a grey wall.
cv::Mat portrait(const cv::Scalar& skin = kPortraitSkin, const cv::Scalar& shirt = kPortraitShirt) {
  cv::Mat picture(240, 320, CV_8UC3, cv::Scalar(190, 187, 178));
  cv::rectangle(picture, {110, 84}, {210, 239}, shirt, cv::FILLED);
  cv::ellipse(picture, {160, 52}, {24, 28}, 0, 0, 360, cv::Scalar(30, 35, 45), cv::FILLED);  // Hair.
  cv::ellipse(picture, {160, 62}, {18, 22}, 0, 0, 360, skin, cv::FILLED);
  for (const int x : {152, 168}) cv::circle(picture, {x, 58}, 2, cv::Scalar(20, 20, 20), cv::FILLED);
  cv::rectangle(picture, {152, 73}, {168, 76}, cv::Scalar(70, 60, 160), cv::FILLED);
  return picture;
}

double posterior_of(const ToneLearner& learner, const cv::Vec3d& bgr) {
  ToneSet set;
  set.put(*learner.skin());
  if (learner.clothes()) set.put(*learner.clothes());
  return set.posteriors(tone_colour(bgr))[0];
}

const cv::Vec3d kSkinPixel(142, 178, 226);

class Learner : public ::testing::TestWithParam<ToneKind> {
 protected:
  Learner() { options_.model = GetParam(); }
  ToneOptions options_;
};

INSTANTIATE_TEST_SUITE_P(Tone, Learner, ::testing::Values(ToneKind::kGaussian, ToneKind::kHistogram),
                         [](const auto& each) { return std::string(name_of(each.param)); });

TEST_P(Learner, KnowsTheSkinFromTheFirstGoodFaceOn) {
  ToneLearner learner(options_);
  EXPECT_FALSE(learner.skin());
  EXPECT_TRUE(learner.add(portrait(), kPortraitFace, 0));
  ASSERT_TRUE(learner.skin());
  EXPECT_EQ(learner.skin()->name, "skin");
  EXPECT_GT(posterior_of(learner, kSkinPixel), 0.9);
  EXPECT_GT(posterior_of(learner, 0.65 * kSkinPixel), 0.5) << "an arm in the shade";
  EXPECT_LT(posterior_of(learner, {132, 66, 36}), 0.01) << "the shirt";
  EXPECT_LT(posterior_of(learner, {190, 187, 178}), 0.1) << "the wall";
  EXPECT_LT(posterior_of(learner, {30, 35, 45}), 0.35) << "the hair";
  EXPECT_LT(posterior_of(learner, {20, 20, 20}), 0.1) << "an eye";
}

TEST_P(Learner, GivesTonesOutAtMostEveryHalfSecond) {
  ToneLearner learner(options_);
  int given = 0;
  for (int i = 0; i <= 60; ++i) given += learner.add(portrait(), kPortraitFace, i / 30.0) ? 1 : 0;
  EXPECT_EQ(given, 5);
  EXPECT_NEAR(learner.learned_s(), 2.0, 1e-9);
}

TEST_P(Learner, FollowsALightThatChangesSlowly) {
  ToneLearner learner(options_);
  const cv::Vec3d warm(0.6 * 142, 0.85 * 178, 226);
  options_.adapt_s = 5;
  learner = ToneLearner(options_);
  for (int i = 0; i < 900; ++i) {
    const double share = i / 899.0;
    const cv::Scalar skin(142 * (1 - 0.4 * share), 178 * (1 - 0.15 * share), 226);
    learner.add(portrait(skin), kPortraitFace, i / 15.0);
  }
  EXPECT_GT(posterior_of(learner, warm), 0.9);
}

TEST_P(Learner, LeavesOutAFaceThatSuddenlyLooksOtherwiseUntilItStays) {
  ToneLearner learner(options_);
  for (int i = 0; i < 30; ++i) learner.add(portrait(), kPortraitFace, i * 0.1);
  const double before = posterior_of(learner, kSkinPixel);
  const cv::Scalar glove(40, 160, 40);
  for (int i = 30; i < 45; ++i) EXPECT_FALSE(learner.add(portrait(glove), kPortraitFace, i * 0.1));
  EXPECT_EQ(posterior_of(learner, kSkinPixel), before);
  for (int i = 45; i < 60; ++i) learner.add(portrait(glove), kPortraitFace, i * 0.1);
  EXPECT_LT(posterior_of(learner, kSkinPixel), 0.1);
  EXPECT_GT(posterior_of(learner, {40, 160, 40}), 0.9);
}

TEST_P(Learner, TwoOddLooksBetweenWhichTheFaceWasHiddenAreNotTwoSeconds) {
  ToneLearner learner(options_);
  for (int i = 0; i < 100; ++i) learner.add(portrait(), kPortraitFace, i * 0.1);
  const double before = posterior_of(learner, kSkinPixel);
  const cv::Scalar glove(40, 160, 40);
  EXPECT_FALSE(learner.add(portrait(glove), kPortraitFace, 10));
  EXPECT_FALSE(learner.add(portrait(glove), kPortraitFace, 13));
  EXPECT_NEAR(learner.learned_s(), 3, 1e-9);
  EXPECT_EQ(posterior_of(learner, kSkinPixel), before);
}

TEST_P(Learner, WhatIsLearnedOnceAndForAllIsGivenOutWholeHoweverSeldomThatIsAsked) {
  options_.adapt_s = 0;
  options_.rebuild_s = 10;
  options_.learn_s = 2;
  ToneLearner learner(options_);
  const cv::Scalar later(120, 160, 226);
  EXPECT_TRUE(learner.add(portrait(), kPortraitFace, 0));
  const double first = posterior_of(learner, {115, 155, 226});
  int given = 0;
  for (int i = 1; i < 120; ++i) {
    given += learner.add(portrait(later), kPortraitFace, i / 30.0) ? 1 : 0;
    EXPECT_TRUE(given == 0 ? i < 62 : given == 1 && i >= 60) << i << " " << given;
  }
  EXPECT_NE(posterior_of(learner, {115, 155, 226}), first);
}

TEST_P(Learner, TakesABareChestForNoClothes) {
  ToneLearner bare(options_);
  bare.add(portrait(kPortraitSkin, kPortraitSkin * 0.9), kPortraitFace, 0);
  EXPECT_FALSE(bare.clothes());
  EXPECT_GT(posterior_of(bare, kSkinPixel), 0.9);
  ToneLearner dressed(options_);
  dressed.add(portrait(), kPortraitFace, 0);
  ASSERT_TRUE(dressed.clothes());
  EXPECT_EQ(dressed.clothes()->name, "clothes");
}

TEST_P(Learner, ForgetsEverybodyOnReset) {
  ToneLearner learner(options_);
  learner.add(portrait(), kPortraitFace, 0);
  learner.reset();
  EXPECT_FALSE(learner.skin());
  EXPECT_EQ(learner.learned_s(), 0);
}

TEST_P(Learner, IsTheSameEveryTime) {
  ToneLearner a(options_);
  ToneLearner b(options_);
  for (int i = 0; i < 10; ++i) {
    a.add(portrait(), kPortraitFace, i * 0.1);
    b.add(portrait(), kPortraitFace, i * 0.1);
  }
  for (int level = 0; level < 256; level += 15) {
    const cv::Vec3d colour(level, 128, 255 - level);
    EXPECT_EQ(posterior_of(a, colour), posterior_of(b, colour));
  }
}

TEST(ToneLearner, LooksAtNoFaceThatCoastsOrLiesOutsideThePicture) {
  ToneLearner learner({});
  auto face = kPortraitFace;
  face.unseen_s = 0.6;
  EXPECT_FALSE(learner.add(portrait(), face, 0));
  face = kPortraitFace;
  face.centre = {-100, 500};
  EXPECT_FALSE(learner.add(portrait(), face, 0.1));
  face.width = 0;
  EXPECT_FALSE(learner.add(portrait(), face, 0.2));
  EXPECT_FALSE(learner.skin());
}

TEST(ToneLearner, NeedsSeveralSmallFaces) {
  ToneLearner learner({});
  cv::Mat small;
  cv::resize(portrait(), small, {}, 0.25, 0.25, cv::INTER_AREA);
  const TrackedFace face{{40, 15}, 9, 1, 0, 0};
  int i = 0;
  while (!learner.add(small, face, i * 0.03) && i < 100) ++i;
  EXPECT_GT(i, 0);
  EXPECT_LT(i, 15);
}

TEST(ToneOptions, AreRefusedByNameAndRange) {
  const auto with = [](auto change) -> std::string {
    ToneOptions options;
    change(options);
    try {
      options.validate();
    } catch (const Error& error) {
      return std::string(error.what()) + " / " + error.hint();
    }
    return "nothing was refused";
  };
  EXPECT_NO_THROW(ToneOptions().validate());
  EXPECT_THAT(with([](auto& o) { o.threshold = 1; }), HasSubstr("tones.threshold is 1 / from 0.01 to 0.99"));
  EXPECT_THAT(with([](auto& o) { o.skin_prior = 0; }), HasSubstr("tones.skin_prior"));
  EXPECT_THAT(with([](auto& o) { o.adapt_s = 0.1; }), HasSubstr("tones.adapt_s"));
  EXPECT_THAT(with([](auto& o) { o.arms.clear(); }), HasSubstr("tones.arms"));
  EXPECT_THAT(with([](auto& o) { o.learn_skin = false; }), HasSubstr("tones.file"));
  EXPECT_THROW((void)tone_kind_named("gausian"), Error);
}

}  // namespace
}  // namespace choreo::vision
