// SPDX-License-Identifier: Apache-2.0
// The bounds of a stretch, and what is none.
#include "body/particle_calibration.hpp"

#include <gtest/gtest.h>

namespace choreo::body {
namespace {

ParticleParts reaching(double alpha, double c, double eta) {
  ParticleParts parts;
  parts.alpha = {0.6 * alpha, 0.8 * alpha};
  parts.c = {Eigen::Vector2d(0, c), Eigen::Vector2d(c / 2, 0)};
  parts.eta = {0, -eta};
  return parts;
}

// 100 frames from nothing to the whole.
ParticleCalibration stretched() {
  ParticleCalibration calibration;
  for (int k = 1; k <= 100; ++k) calibration.add(reaching(0.05 * k, 0.002 * k, 0.06 * k));
  return calibration;
}

TEST(ParticleCalibration, TakesTheLongestThatWasHeld) {
  const auto bounds = stretched().bounds();
  // The third largest of 100 frames.
  EXPECT_NEAR(bounds.alpha_max, 0.05 * 98, 1e-12);
  EXPECT_NEAR(bounds.c_max, 0.002 * 98, 1e-12);
  EXPECT_NEAR(bounds.eta_max, 0.06 * 98, 1e-12);
  EXPECT_NO_THROW(bounds.validate());
}

TEST(ParticleCalibration, WildFramesChangeItByNoMoreThanTheNextFrames) {
  auto calibration = stretched();
  for (int k = 0; k < 2; ++k) calibration.add(reaching(90, 90, 90));
  const auto bounds = calibration.bounds();
  EXPECT_NEAR(bounds.alpha_max, 0.05 * 100, 1e-12);
  EXPECT_NEAR(bounds.c_max, 0.002 * 100, 1e-12);
  EXPECT_NEAR(bounds.eta_max, 0.06 * 100, 1e-12);
}

TEST(ParticleCalibration, OfTooFewFramesIsTheVitruvianFigure) {
  ParticleCalibration calibration;
  for (std::size_t k = 0; k + 1 < ParticleCalibration::kLeastFrames; ++k) calibration.add(reaching(3, 0.15, 4));
  EXPECT_EQ(calibration.bounds().alpha_max, ParticleBounds{}.alpha_max);
  EXPECT_EQ(calibration.frames(), ParticleCalibration::kLeastFrames - 1);
  calibration.add(reaching(3, 0.15, 4));
  EXPECT_NEAR(calibration.bounds().alpha_max, 3, 1e-12);
}

TEST(ParticleCalibration, WhoStandsStillHasNotStretched) {
  ParticleCalibration calibration;
  for (int k = 0; k < 100; ++k) calibration.add(reaching(0.01, 0.001, 0.01));
  const auto bounds = calibration.bounds();
  EXPECT_EQ(bounds.alpha_max, ParticleBounds{}.alpha_max / 2);
  EXPECT_EQ(bounds.c_max, ParticleBounds{}.c_max / 4);
  EXPECT_EQ(bounds.eta_max, ParticleBounds{}.eta_max / 2);
  EXPECT_NEAR(calibration.reached().alpha_max, 0.01, 1e-12) << "which can be told from a stretch";
}

}  // namespace
}  // namespace choreo::body
