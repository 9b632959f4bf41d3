// SPDX-License-Identifier: Apache-2.0
#include "vision/tone_model.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.hpp"

namespace choreo::vision {
namespace {

using ::testing::HasSubstr;

constexpr double kPi = std::numbers::pi;

GaussianTone::Parameters narrow_tone() {
  GaussianTone::Parameters p;
  p.mean = {0.3, 0.1, 0.6};
  p.covariance = {0.004, 0.001, 0.0005, 0.001, 0.003, -0.0004, 0.0005, -0.0004, 0.01};
  p.noise = 2;
  return p;
}

HistogramTone::Parameters one_cell() {
  HistogramTone::Parameters p;
  p.weights.assign(std::size_t(HistogramTone::kCells) * HistogramTone::kCells, 0.0F);
  p.weights[HistogramTone::cell_of(0.3, 0.1)] = 5;
  return p;
}

// The integral over the disc at one value.
double integral_over_disc(const ToneModel& model, double v) {
  constexpr int kSteps = 800;
  constexpr double kStep = 2.0 / kSteps;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const double x = (i + 0.5) * kStep - 1;
      const double y = (j + 0.5) * kStep - 1;
      if (x * x + y * y <= 1) sum += model.density({x, y, v}) * kStep * kStep;
    }
  }
  return sum;
}

template <typename Make>
std::string complaint(Make make) {
  try {
    make();
  } catch (const Error& error) {
    EXPECT_EQ(error.fault(), Fault::kUsage);
    return error.what();
  }
  return "nothing was refused";
}

TEST(ToneColour, IsHueAndSaturationAsAPlaceInTheDisc) {
  const auto red = tone_colour({0, 0, 255});
  EXPECT_NEAR(red.x, 1, 1e-12);
  EXPECT_NEAR(red.y, 0, 1e-12);
  EXPECT_NEAR(red.v, 1, 1e-12);
  const auto green = tone_colour({64, 128, 64});  // Hue a third of a turn, saturation a half.
  EXPECT_NEAR(green.x, 0.5 * std::cos(2 * kPi / 3), 1e-12);
  EXPECT_NEAR(green.y, 0.5 * std::sin(2 * kPi / 3), 1e-12);
  const auto blue = tone_colour({200, 0, 0});
  EXPECT_NEAR(std::atan2(blue.y, blue.x), -2 * kPi / 3, 1e-12);
}

TEST(ToneColour, OfGreyAndBlackIsTheMiddle) {
  for (const double level : {0.0, 1.0, 128.0, 255.0}) {
    const auto c = tone_colour({level, level, level});
    EXPECT_EQ(c.x, 0);
    EXPECT_EQ(c.y, 0);
    EXPECT_DOUBLE_EQ(c.v, level / 255);
  }
}

TEST(ToneColour, HasNoSeamAtRed) {
  const auto a = tone_colour({60, 61, 200});
  const auto b = tone_colour({61, 60, 200});
  EXPECT_NEAR(std::hypot(a.x - b.x, a.y - b.y), 0, 0.011);
}

TEST(GaussianTone, WithoutNoiseIsThePlainDensityWithItsFactor) {
  auto p = narrow_tone();
  p.noise = 0;
  p.covariance = cv::Matx33d::diag({0.01, 0.04, 0.0025});
  const GaussianTone tone(p);
  const double rounding = std::pow(tone_noise(0.6, 0), 2);  // What is left of noise: 8 bits.
  const double peak = std::pow(2 * kPi, -1.5) / std::sqrt((0.01 + rounding) * (0.04 + rounding) * 0.0025);
  EXPECT_NEAR(tone.density({0.3, 0.1, 0.6}), peak, 1e-5 * peak);
  EXPECT_NEAR(tone.density({0.4, 0.1, 0.6}), peak * std::exp(-0.5), 1e-3 * peak);
  EXPECT_NEAR(tone.density({0.3, 0.1, 0.65}), peak * std::exp(-0.5), 1e-3 * peak);
}

TEST(GaussianTone, IntegratesToOneOverTheSpace) {
  const GaussianTone tone(narrow_tone());
  double sum = 0;
  for (double v = 0.05; v < 1.2; v += 0.05) sum += 0.05 * integral_over_disc(tone, v);
  EXPECT_NEAR(sum, 1, 0.01);
}

TEST(GaussianTone, WithAnyValueIntegratesToOneOverTheDiscAtEach) {
  auto p = narrow_tone();
  for (int i = 0; i < 3; ++i) p.covariance(i, 2) = p.covariance(2, i) = 0;
  const GaussianTone tone(p);
  EXPECT_FALSE(tone.with_value());
  EXPECT_NEAR(integral_over_disc(tone, 0.9), 1, 0.01);
  EXPECT_NEAR(integral_over_disc(tone, 0.3), 1, 0.01);
}

TEST(GaussianTone, OfPixelsHasTheirMeanAndCovarianceAndThatOfRounding) {
  const std::vector<cv::Vec3b> flat(100, cv::Vec3b(100, 150, 200));
  const auto p = GaussianTone::fitted(flat).parameters();
  const auto c = tone_colour({100, 150, 200});
  EXPECT_NEAR(p.mean[0], c.x, 1e-12);
  EXPECT_NEAR(p.mean[1], c.y, 1e-12);
  EXPECT_NEAR(p.mean[2], c.v, 1e-12);
  EXPECT_NEAR(p.covariance(2, 2), 1.0 / 12 / 255 / 255, 1e-12);
  EXPECT_NEAR(p.covariance(0, 0), std::pow(tone_noise(c.v, 0), 2), 1e-12);
  EXPECT_NEAR(p.covariance(0, 1), 0, 1e-12);
}

TEST(GaussianTone, RefusesWhatIsNoCovarianceAndWhatIsNoNumber) {
  const auto with = [](auto change) {
    return complaint([&] {
      auto p = narrow_tone();
      change(p);
      (void)GaussianTone(p);
    });
  };
  using P = GaussianTone::Parameters;
  EXPECT_THAT(with([](P& p) { p.mean[1] = std::nan(""); }), HasSubstr("no number"));
  EXPECT_THAT(with([](P& p) { p.covariance(0, 0) = std::numeric_limits<double>::infinity(); }), HasSubstr("no number"));
  EXPECT_THAT(with([](P& p) { p.covariance(0, 1) = 0.002; }), HasSubstr("not symmetric"));
  EXPECT_THAT(with([](P& p) { p.covariance(0, 0) = -0.004; }), HasSubstr("not positive definite"));
  EXPECT_THAT(with([](P& p) { p.covariance = cv::Matx33d::zeros(); }), HasSubstr("not positive definite"));
  EXPECT_THAT(with([](P& p) { p.covariance = {1, 1, 0, 1, 1, 0, 0, 0, 1}; }), HasSubstr("singular"));
  EXPECT_THAT(with([](P& p) { p.noise = -1; }), HasSubstr("noise"));
}

TEST(Tones, OfTooFewPixelsAreRefused) {
  const std::vector<cv::Vec3b> few(15, cv::Vec3b(100, 150, 200));
  EXPECT_THAT(complaint([&] { (void)GaussianTone::fitted(few); }), HasSubstr("too few pixels for a tone: 15"));
  EXPECT_THAT(complaint([&] { (void)HistogramTone::fitted(few); }), HasSubstr("too few pixels"));
  EXPECT_THAT(complaint([&] { (void)fitted_parts({}, {}); }), HasSubstr("too few pixels for a tone: 0"));
}

TEST(HistogramTone, IntegratesToOneAndIsHighestWhereItsPixelsAre) {
  const HistogramTone tone(one_cell());
  EXPECT_NEAR(integral_over_disc(tone, 0.9), 1, 0.01);
  EXPECT_NEAR(integral_over_disc(tone, 0.1), 1, 0.02);  // Noise makes it wide, and takes nothing away.
  EXPECT_GT(tone.density({0.3, 0.1, 0.9}), 100 * tone.density({0.5, 0.1, 0.9}));
  EXPECT_GT(tone.density({0.5, 0.1, 0.1}), tone.density({0.5, 0.1, 0.9}));
}

TEST(HistogramTone, OfNormalPixelsIsTheNormalDensityWithinASixth) {
  std::vector<cv::Vec3b> pixels;
  for (int i = -12; i <= 12; ++i) {
    for (int j = -12; j <= 12; ++j) {
      const int times = cvRound(20 * std::exp(-0.5 * (i * i + j * j) / 25.0));
      for (int k = 0; k < times; ++k) {
        pixels.emplace_back(static_cast<std::uint8_t>(110 + i), static_cast<std::uint8_t>(140 + j), std::uint8_t(200));
      }
    }
  }
  ToneFit fit;
  fit.with_value = false;
  fit.smoothing = 0.03;
  const auto histogram = HistogramTone::fitted(pixels, fit);
  auto p = GaussianTone::fitted(pixels, fit).parameters();
  p.covariance(0, 0) += 0.03 * 0.03;
  p.covariance(1, 1) += 0.03 * 0.03;
  const GaussianTone gaussian(p);
  const double peak = gaussian.density({p.mean[0], p.mean[1], 0.8});
  for (const double dx : {-0.03, 0.0, 0.03}) {
    const ToneColour at{p.mean[0] + dx, p.mean[1], 0.8};
    EXPECT_NEAR(histogram.density(at), gaussian.density(at), peak / 6) << dx;
  }
}

TEST(HistogramTone, RefusesWhatIsNoHistogram) {
  const auto with = [](auto change) {
    return complaint([&] {
      auto p = one_cell();
      change(p);
      (void)HistogramTone(p);
    });
  };
  using P = HistogramTone::Parameters;
  EXPECT_THAT(with([](P& p) { p.weights.pop_back(); }), HasSubstr("cells"));
  EXPECT_THAT(with([](P& p) { p.weights[0] = -1; }), HasSubstr("negative or no number"));
  EXPECT_THAT(with([](P& p) { p.weights[0] = std::nanf(""); }), HasSubstr("negative or no number"));
  EXPECT_THAT(with([](P& p) { p.weights.assign(p.weights.size(), 0.0F); }), HasSubstr("empty"));
  EXPECT_THAT(with([](P& p) { p.smoothing = 0; }), HasSubstr("smoothing"));
  EXPECT_THAT(with([](P& p) { p.value.deviation = std::nan(""); }), HasSubstr("of v"));
}

ToneSet one_tone() {
  ToneSet set;
  set.put({"glove", 0.25, {{1, std::make_shared<GaussianTone>(narrow_tone())}}});
  set.outliers = 0.75;
  return set;
}

TEST(ToneSet, HasOutliersThatIntegrateToOne) {
  double sum = 0;
  for (int i = 0; i < 10000; ++i) sum += kPi * outlier_density((i + 0.5) * 1e-4) * 1e-4;
  EXPECT_NEAR(sum, 1, 1e-4);
}

// P(tone) p / (P(tone) p + P(outliers) p'), by hand.
TEST(ToneSet, IsBayesRule) {
  const auto set = one_tone();
  const ToneColour at{0.35, 0.05, 0.5};
  const double p = set.tones[0].parts[0].model->density(at);
  const auto posterior = set.posteriors(at);
  ASSERT_EQ(posterior.size(), 2U);
  EXPECT_NEAR(posterior[0], 0.25 * p / (0.25 * p + 0.75 * outlier_density(0.5)), 1e-9);
  EXPECT_NEAR(posterior[0] + posterior[1], 1, 1e-12);
}

TEST(ToneSet, OfTwoLikeTonesGivesEachItsShareOfThePriors) {
  auto set = one_tone();
  auto second = set.tones[0];
  second.name = "sleeve";
  second.prior = 0.5;
  set.put(second);
  const auto posterior = set.posteriors({0.3, 0.1, 0.6});
  EXPECT_NEAR(posterior[1] / posterior[0], 2, 1e-9);
}

TEST(ToneSet, ATonePutAgainTakesItsPlace) {
  auto set = one_tone();
  auto other = set.tones[0];
  other.prior = 0.9;
  set.put(other);
  ASSERT_EQ(set.tones.size(), 1U);
  EXPECT_EQ(set.tones[0].prior, 0.9);
  EXPECT_EQ(set.find("glove"), 0U);
  EXPECT_EQ(set.find("hat"), 1U);
}

TEST(ToneSet, RefusesNamesAndPriorsThatAreNone) {
  const auto with = [](auto change) {
    auto set = one_tone();
    change(set);
    return complaint([&] { set.validate(); });
  };
  EXPECT_THAT(with([](ToneSet& s) { s.tones[0].name = ""; }), HasSubstr("no name"));
  EXPECT_THAT(with([](ToneSet& s) { s.tones[0].name = "outliers"; }), HasSubstr("outliers"));
  EXPECT_THAT(with([](ToneSet& s) { s.tones.push_back(s.tones[0]); }), HasSubstr("twice"));
  EXPECT_THAT(with([](ToneSet& s) { s.tones[0].prior = 0; }), HasSubstr("prior"));
  EXPECT_THAT(with([](ToneSet& s) { s.outliers = std::nan(""); }), HasSubstr("outliers"));
  EXPECT_THAT(with([](ToneSet& s) { s.tones[0].parts.clear(); }), HasSubstr("no model"));
  EXPECT_THAT(with([](ToneSet& s) { s.tones[0].parts[0].weight = -1; }), HasSubstr("weight"));
}

TEST(Tones, ATwoColouredFlagIsTwoParts) {
  std::vector<cv::Vec3b> flag(300, cv::Vec3b(30, 30, 210));
  flag.insert(flag.end(), 100, cv::Vec3b(20, 200, 230));
  ToneFit fit;
  fit.parts = 2;
  ToneSet set;
  set.put({"flag", 0.2, fitted_parts(flag, fit)});
  ASSERT_EQ(set.tones[0].parts.size(), 2U);
  EXPECT_NEAR(set.tones[0].parts[0].weight + set.tones[0].parts[1].weight, 1, 1e-12);
  EXPECT_NEAR(std::abs(set.tones[0].parts[0].weight - set.tones[0].parts[1].weight), 0.5, 1e-12);
  EXPECT_GT(set.posteriors(tone_colour({30, 30, 210}))[0], 0.95);
  EXPECT_GT(set.posteriors(tone_colour({20, 200, 230}))[0], 0.95);
  EXPECT_LT(set.posteriors(tone_colour({25, 115, 220}))[0], 0.5);  // Orange is in between, and in neither.
}

// What is painted over a flag has its stick in it: few pixels, and the farthest from all others.
TEST(Tones, AStickIsNoPartOfATwoColouredFlag) {
  std::vector<cv::Vec3b> flag(300, cv::Vec3b(30, 30, 210));
  flag.insert(flag.end(), 300, cv::Vec3b(20, 200, 230));
  flag.insert(flag.end(), 25, cv::Vec3b(90, 60, 40));
  ToneFit fit;
  fit.parts = 2;
  const auto parts = fitted_parts(flag, fit);
  ASSERT_EQ(parts.size(), 2U);
  for (const auto& part : parts) EXPECT_NEAR(part.weight, 0.5, 0.05);
}

// Sensor noise around black and dark grey has any hue and saturation.
TEST(Tones, DarkPixelsFallToTheOutliers) {
  ToneSet set;
  GaussianTone::Parameters p = narrow_tone();
  p.covariance(0, 2) = p.covariance(2, 0) = p.covariance(1, 2) = p.covariance(2, 1) = 0;
  set.put({"skin", 0.3, {{1, std::make_shared<GaussianTone>(p)}}});
  int found = 0;
  int all = 0;
  for (int b = 0; b <= 12; ++b) {
    for (int g = 0; g <= 12; ++g) {
      for (int r = 0; r <= 12; ++r, ++all) {
        if (set.posteriors(tone_colour(cv::Vec3d(b, g, r)))[0] >= 0.5) ++found;
      }
    }
  }
  EXPECT_EQ(found, 0) << "of " << all;
  // Even where v says nothing: what noise alone could make of grey is not the tone's.
  p.covariance(2, 2) = 0;
  p.mean[2] = 0;
  set.put({"skin", 0.3, {{1, std::make_shared<GaussianTone>(p)}}});
  EXPECT_LT(set.posteriors(tone_colour({4, 5, 6}))[0], 0.5);
  EXPECT_GT(set.posteriors(tone_colour({136, 150, 200}))[0], 0.5);
}

}  // namespace
}  // namespace choreo::vision
