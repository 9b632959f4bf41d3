// SPDX-License-Identifier: Apache-2.0
#include "vision/tone_mapper.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace choreo::vision {
namespace {

GaussianTone::Parameters tone_at(double x, double y, double v) {
  GaussianTone::Parameters p;
  p.mean = {x, y, v};
  p.covariance = cv::Matx33d::diag({0.004, 0.003, 0.03});
  return p;
}

ToneSet two_tones() {
  ToneSet set;
  set.put({"skin", 0.3, {{1, std::make_shared<GaussianTone>(tone_at(0.35, 0.12, 0.7))}}});
  set.put({"glove", 0.2, {{1, std::make_shared<GaussianTone>(tone_at(-0.3, -0.5, 0.5))}}});
  return set;
}

// One pixel of each colour, spread over all of them.
cv::Mat many_colours() {
  cv::Mat picture(64, 64, CV_8UC3);
  for (int i = 0; i < 4096; ++i) {
    const auto at = [&](int step, int offset) { return static_cast<std::uint8_t>((i * step + offset) % 256); };
    picture.at<cv::Vec3b>(i / 64, i % 64) = {at(37, 5), at(101, 40), at(11, 90)};
  }
  return picture;
}

// Table cells are 4 levels wide; the posterior may change by that much across half of one.
TEST(ToneMapper, IsBayesRuleWithinTheCellsError) {
  const auto set = two_tones();
  const ToneMapper mapper(set);
  std::array<double, 2> worst{};
  double sum = 0;
  int count = 0;
  int wrong = 0;
  for (int b = 1; b < 256; b += 5) {
    for (int g = 1; g < 256; g += 5) {
      for (int r = 1; r < 256; r += 3) {
        const cv::Mat pixel(1, 1, CV_8UC3, cv::Scalar(b, g, r));
        const auto exact = set.posteriors(tone_colour(cv::Vec3d(b, g, r)));
        for (std::size_t t = 0; t < 2; ++t) {
          const double looked_up = mapper.posterior(pixel, {}, t).at<std::uint8_t>(0, 0) / 255.0;
          const double error = std::abs(looked_up - exact[t]);
          worst[t] = std::max(worst[t], error);
          sum += error;
          wrong += (looked_up > 0.5) != (exact[t] > 0.5) ? 1 : 0;
          ++count;
        }
      }
    }
  }
  std::printf("look-up: worst error %.3f and %.3f, mean %.5f, on the wrong side of 0.5 one in %.0f\n", worst[0],
              worst[1], sum / count, double(count) / wrong);
  EXPECT_LT(worst[0], 0.355);
  EXPECT_LT(worst[1], 0.355);
  EXPECT_LT(sum / count, 0.003);
}

TEST(ToneMapper, AtTheCentreOfACellIsExactToTheRounding) {
  const auto set = two_tones();
  const ToneMapper mapper(set);
  // Between the levels 101 and 102 the cells 100 to 103 have their centre: both sides are as far from it.
  const auto exact = set.posteriors(tone_colour({101.5, 121.5, 181.5}))[0];
  const cv::Mat pixel(1, 1, CV_8UC3, cv::Scalar(100, 120, 183));
  EXPECT_NEAR(mapper.posterior(pixel, {}, 0).at<std::uint8_t>(0, 0) / 255.0, exact, 0.5 / 255 + 1e-4);
}

TEST(ToneMapper, OutsideTheMaskThereIsNone) {
  const ToneMapper mapper(two_tones());
  const cv::Mat picture(4, 6, CV_8UC3, cv::Scalar(116, 140, 179));
  cv::Mat mask = cv::Mat::zeros(4, 6, CV_8UC1);
  mask.at<std::uint8_t>(2, 3) = 1;
  const cv::Mat found = mapper.posterior(picture, mask, 0);
  EXPECT_EQ(cv::countNonZero(found), 1);
  EXPECT_GT(found.at<std::uint8_t>(2, 3), 200);
  EXPECT_EQ(cv::countNonZero(mapper.posterior(picture, {}, 0)), 24);
}

TEST(ToneMapper, OfSeveralTonesIsTheirSum) {
  const ToneMapper mapper(two_tones());
  const cv::Mat picture = many_colours();
  const std::vector<std::size_t> both{0, 1};
  const cv::Mat any = mapper.posterior(picture, {}, both);
  const cv::Mat skin = mapper.posterior(picture, {}, 0);
  const cv::Mat glove = mapper.posterior(picture, {}, 1);
  cv::Mat sum;
  cv::add(skin, glove, sum);
  EXPECT_EQ(cv::norm(any, sum, cv::NORM_INF), 0);
  EXPECT_EQ(cv::countNonZero(mapper.posterior(picture, {}, std::span<const std::size_t>())), 0);
}

TEST(ToneMapper, ReadsPartsOfLargerPictures) {
  const ToneMapper mapper(two_tones());
  const cv::Mat picture = many_colours();
  const cv::Rect part(5, 7, 20, 30);
  EXPECT_EQ(cv::norm(mapper.posterior(picture(part), {}, 0), mapper.posterior(picture, {}, 0)(part), cv::NORM_INF), 0);
  EXPECT_TRUE(mapper.posterior(cv::Mat(0, 0, CV_8UC3), {}, 0).empty());
}

TEST(ToneMapper, RebuiltIsAsNew) {
  ToneMapper old(two_tones());
  auto other = two_tones();
  other.put({"skin", 0.1, {{1, std::make_shared<GaussianTone>(tone_at(0.2, 0.2, 0.4))}}});
  other.put({"flag", 0.1, {{1, std::make_shared<GaussianTone>(tone_at(0.9, 0.0, 0.8))}}});
  old.rebuild(other);
  const ToneMapper fresh(other);
  for (std::size_t t = 0; t < 3; ++t) {
    EXPECT_EQ(cv::norm(old.posterior(many_colours(), {}, t), fresh.posterior(many_colours(), {}, t), cv::NORM_INF), 0);
  }
}

TEST(ToneMapper, IsPreparedForOtherTonesPieceByPieceAndThenAsNew) {
  auto other = two_tones();
  other.put({"flag", 0.1, {{1, std::make_shared<GaussianTone>(tone_at(0.9, 0.0, 0.8))}}});
  const ToneMapper fresh(other);
  const ToneMapper before(two_tones());
  const auto same = [](const ToneMapper& a, const ToneMapper& b, std::size_t tone) {
    return cv::norm(a.posterior(many_colours(), {}, tone), b.posterior(many_colours(), {}, tone), cv::NORM_INF) == 0;
  };
  for (const int parts : {1, 2, 7, 8}) {
    ToneMapper mapper(two_tones());
    EXPECT_FALSE(mapper.advance(parts)) << "nothing was begun";
    mapper.prepare(two_tones());
    (void)mapper.advance(3);
    mapper.prepare(other);  // The other is given up.
    for (int i = 1; i < parts; ++i) {
      EXPECT_FALSE(mapper.advance(parts));
      EXPECT_EQ(mapper.tones().tones.size(), 2U);
      EXPECT_TRUE(same(mapper, before, 0) && same(mapper, before, 1));
    }
    EXPECT_TRUE(mapper.advance(parts));
    ASSERT_EQ(mapper.tones().tones.size(), 3U);
    for (std::size_t tone = 0; tone < 3; ++tone) EXPECT_TRUE(same(mapper, fresh, tone)) << parts;
    EXPECT_FALSE(mapper.advance(parts));
  }
}

}  // namespace
}  // namespace choreo::vision
