// SPDX-License-Identifier: Apache-2.0
// MATH.md section 3 on states small enough to be worked by hand.
#include "body/particle_state.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/error.hpp"
#include "support/particles.hpp"

namespace choreo::body {
namespace {

using vision::Moments;

constexpr double kFaceWidth = 20;
const cv::Point2d kFace(100, 50);
const double kHalfRoot3 = std::sqrt(3.0) / 2;

// A slender ellipse-like blob: the second moments of one of half axes a and b, its long axis `turns` to the picture's
// x axis (y down).
Moments arm_at(cv::Point2d centre, double a, double b, double turn) {
  Moments m;
  m.m00 = std::numbers::pi * a * b;
  m.centroid = centre;
  const double c = std::cos(turn);
  const double s = std::sin(turn);
  m.mu20 = m.m00 * (a * a * c * c + b * b * s * s) / 4;
  m.mu02 = m.m00 * (a * a * s * s + b * b * c * c) / 4;
  m.mu11 = m.m00 * (a * a - b * b) * c * s / 4;
  return m;
}

// What a camera sees of it when the picture, `width` pixels wide, is flipped.
Moments flipped(Moments m, double width) {
  m.centroid.x = width - 1 - m.centroid.x;
  m.mu11 = -m.mu11;
  m.mu30 = -m.mu30;
  m.mu12 = -m.mu12;
  return m;
}

void expect_near(const ParticleState& a, const std::array<double, kParticleValues>& psi, double tolerance) {
  for (std::size_t k = 0; k < psi.size(); ++k) EXPECT_NEAR(a.psi()[k], psi[k], tolerance) << "value " << k;
}

void expect_same_bits(const ParticleState& a, const ParticleState& b) {
  for (std::size_t k = 0; k < a.psi().size(); ++k) EXPECT_EQ(a.psi()[k], b.psi()[k]) << "value " << k;
}

TEST(Lift, GoesFromThePoleToTheEquatorAndStaysThere) {
  EXPECT_EQ(lift({0, 0}, 2), Eigen::Vector3d(1, 0, 0));
  EXPECT_TRUE(lift({0, 1}, 2).isApprox(Eigen::Vector3d(kHalfRoot3, 0, 0.5), 1e-15));
  EXPECT_TRUE(lift({-1.2, 1.6}, 2).isApprox(Eigen::Vector3d(0, -0.6, 0.8), 1e-15));
  EXPECT_TRUE(lift({30, 40}, 2).isApprox(Eigen::Vector3d(0, 0.6, 0.8), 1e-15));
}

TEST(Lift, HasLengthOneForVectorsOfEverySize) {
  for (const double length : {5e-324, 1e-300, 1e-9, 0.3, 0.999999999, 1.0, 7.0, 1e300}) {
    EXPECT_NEAR(lift({length, -length}, 1).norm(), 1, 1e-15) << length;
  }
}

TEST(ParticleState, ArmsHeldLevelMakeTheWorkedExample) {
  // The arms 60 px to either side, 20 px below the face, the face 20 px wide: alpha = (-3, 0), eta = (0, -1). Both lie
  // level: cov_xx = 30^2 / 4 px^2, cov_yy = 10^2 / 4, so c = (800 / 4 / 2, 0) / 400 = (0.25, 0).
  const ParticleBounds bounds{.alpha_max = 6, .c_max = 0.5, .eta_max = 2};
  const ParticleState state(arm_at({40, 70}, 30, 10, 0), arm_at({160, 70}, 30, 10, 0), kFace, kFaceWidth, bounds);
  EXPECT_TRUE(state.parts().alpha.isApprox(Eigen::Vector2d(-3, 0)));
  EXPECT_TRUE(state.parts().eta.isApprox(Eigen::Vector2d(0, -1)));
  EXPECT_TRUE(state.parts().c[0].isApprox(Eigen::Vector2d(0.25, 0)));
  EXPECT_TRUE(state.parts().c[1].isApprox(Eigen::Vector2d(0.25, 0)));
  EXPECT_FALSE(state.joined());
  // Every length is half its bound: beta = 30 degrees, phi = 180.
  expect_near(state,
              {kHalfRoot3, 0, -0.5, kHalfRoot3, 0.5, 0, 2 * kHalfRoot3, 1, 0,  //
               0, 0, 0, 0, 0, 0},
              1e-15);
}

TEST(ParticleState, ASlantedArmBesideALevelOneMakesTheWorkedExample) {
  // One arm level to the right of the face, the other 45 degrees upwards to the right, above it: alpha points up.
  const ParticleBounds bounds{.alpha_max = 2, .c_max = 0.5, .eta_max = 4};
  const double upwards = -std::numbers::pi / 4;
  const ParticleState state(arm_at({140, 30}, 30, 10, upwards), arm_at({140, 70}, 30, 10, 0), kFace, kFaceWidth,
                            bounds);
  EXPECT_TRUE(state.parts().alpha.isApprox(Eigen::Vector2d(0, 1)));
  EXPECT_TRUE(state.parts().eta.isApprox(Eigen::Vector2d(2, 0)));
  EXPECT_TRUE(state.parts().c[0].isApprox(Eigen::Vector2d(0, 0.25), 1e-12));
  EXPECT_TRUE(state.parts().c[1].isApprox(Eigen::Vector2d(0.25, 0), 1e-12));
  // zeta1 = (r, 0, 1/2), zeta2 = (r, 1/2, 0), r = sqrt(3)/2; beta = 30, phi = 90 degrees.
  expect_near(state,
              {kHalfRoot3, 0.5, 0, kHalfRoot3, -0.5, 0, 2 * kHalfRoot3, 0.5, 0.5,  //
               0, 0, 0, -0.25, 0, 0.25},
              1e-15);
}

TEST(ParticleState, SwappingTheArmsChangesNothingToTheLastBit) {
  std::mt19937 random(1);
  for (int k = 0; k < 300; ++k) {
    const auto some = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    const auto one = arm_at({some(0, 200), some(0, 200)}, some(5, 40), some(2, 9), some(0, 4));
    const auto other = arm_at({some(0, 200), some(0, 200)}, some(5, 40), some(2, 9), some(0, 4));
    expect_same_bits(ParticleState(one, other, kFace, kFaceWidth), ParticleState(other, one, kFace, kFaceWidth));
  }
}

TEST(ParticleState, MirroringThePictureGivesTheMirroredState) {
  std::mt19937 random(2);
  for (int k = 0; k < 300; ++k) {
    const auto some = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    const double width = 640;
    const cv::Point2d face(some(100, 540), some(50, 200));
    const auto one = arm_at({some(0, 640), some(0, 480)}, some(5, 40), some(2, 9), some(0, 4));
    const auto other = arm_at({some(0, 640), some(0, 480)}, some(5, 40), some(2, 9), some(0, 4));
    const auto straight = mirrored(ParticleState(one, other, face, kFaceWidth));
    const ParticleState seen(flipped(one, width), flipped(other, width), {width - 1 - face.x, face.y}, kFaceWidth);
    expect_near(seen, straight.psi(), 1e-12);
    EXPECT_TRUE(seen.parts().alpha.isApprox(straight.parts().alpha, 1e-12));
    EXPECT_TRUE(seen.parts().nu.isApprox(straight.parts().nu, 1e-12));
    EXPECT_TRUE(seen.parts().eta.isApprox(straight.parts().eta, 1e-12));
    EXPECT_TRUE(seen.parts().u.isApprox(straight.parts().u, 1e-12));
    for (std::size_t arm = 0; arm < 2; ++arm) {
      EXPECT_TRUE(seen.parts().c[arm].isApprox(straight.parts().c[arm], 1e-12));
      EXPECT_TRUE(seen.parts().zeta[arm].isApprox(straight.parts().zeta[arm], 1e-12));
    }
  }
}

TEST(ParticleState, MirroringFollowsTheSignPatternOfTheTheory) {
  // [+-+ | ++- | ++- | -+ -+ +-]
  const std::array<double, kParticleValues> signs{1, -1, 1, 1, 1, -1, 1, 1, -1, -1, 1, -1, 1, 1, -1};
  ParticleParts parts;
  parts.alpha = {1, 0.7};
  parts.eta = {0.5, -2};
  parts.c = {Eigen::Vector2d(0.05, 0.1), Eigen::Vector2d(-0.02, 0.04)};
  const ParticleState state(parts, {});
  const auto mirror = mirrored(state);
  for (std::size_t k = 0; k < signs.size(); ++k) {
    EXPECT_NE(state.psi()[k], 0);
    EXPECT_EQ(mirror.psi()[k], signs[k] * state.psi()[k]);
  }
}

TEST(ParticleState, WhereInThePictureTheBodyStandsDoesNotMatter) {
  const ParticleState here(arm_at({40, 70}, 30, 10, 0.3), arm_at({160, 20}, 25, 8, 1.1), kFace, kFaceWidth);
  const cv::Point2d step(512, -64);
  const ParticleState there(arm_at(cv::Point2d(40, 70) + step, 30, 10, 0.3),
                            arm_at(cv::Point2d(160, 20) + step, 25, 8, 1.1), kFace + step, kFaceWidth);
  expect_near(there, here.psi(), 1e-14);
}

TEST(ParticleState, HowLargeTheBodyIsSeenDoesNotMatter) {
  const ParticleState near(arm_at({40, 70}, 30, 10, 0.3), arm_at({160, 20}, 25, 8, 1.1), kFace, kFaceWidth);
  for (const double scale : {0.25, 0.3, 3.0, 17.0}) {
    const ParticleState far(arm_at(scale * cv::Point2d(40, 70), scale * 30, scale * 10, 0.3),
                            arm_at(scale * cv::Point2d(160, 20), scale * 25, scale * 8, 1.1), scale * kFace,
                            scale * kFaceWidth);
    expect_near(far, near.psi(), 1e-13);
  }
}

TEST(ParticleState, JoinedHandsAreOneBlobTwice) {
  const auto blob = arm_at({100, 130}, 30, 10, 0.2);
  const ParticleState state(blob, blob, kFace, kFaceWidth);
  EXPECT_TRUE(state.joined());
  EXPECT_TRUE(mirrored(state).joined());
  EXPECT_EQ(state.parts().alpha, Eigen::Vector2d(0, 0));
  EXPECT_EQ(state.parts().zeta[0], state.parts().zeta[1]);
  EXPECT_EQ(state.psi()[3], 1);
  for (std::size_t k = 9; k < 15; ++k) EXPECT_EQ(state.psi()[k], 0);
}

TEST(ParticleState, OfWhatWasFoundNeedsAFaceAndBothArms) {
  using vision::ArmCase;
  vision::Arms arms;
  arms.blob[0].moments = arm_at({40, 70}, 30, 10, 0.3);
  arms.blob[1].moments = arm_at({160, 20}, 25, 8, 1.1);
  vision::TrackedFace face;
  face.centre = kFace;
  face.width = kFaceWidth;
  for (const auto found : {ArmCase::kNoFace, ArmCase::kNoArm, ArmCase::kOneArm}) {
    arms.found = found;
    EXPECT_FALSE(particle_state_of(arms, face)) << vision::name_of(found);
  }
  arms.found = ArmCase::kTwoArms;
  EXPECT_FALSE(particle_state_of(arms, std::nullopt));
  const ParticleState both(arms.blob[0].moments, arms.blob[1].moments, kFace, kFaceWidth);
  ASSERT_TRUE(particle_state_of(arms, face));
  expect_same_bits(*particle_state_of(arms, face), both);
  arms.found = ArmCase::kJoined;
  arms.blob[1] = {};
  ASSERT_TRUE(particle_state_of(arms, face));
  EXPECT_TRUE(particle_state_of(arms, face)->joined());
}

TEST(ParticleState, ThePictureOfTheFigureWithItsArmsOutReachesTheDefaultBounds) {
  // Shoulders 1.25 aside, upper arms 1.25, forearms 2.5 long: their middles are 3.75 from the body's middle.
  const double reach = 3.75 * kFaceWidth;
  const ParticleState state(arm_at(kFace - cv::Point2d(reach, -26), 25, 5, 0),
                            arm_at(kFace + cv::Point2d(reach, 26), 25, 5, 0), kFace, kFaceWidth);
  EXPECT_NEAR(state.parts().nu.x(), 0, 1e-7);
  EXPECT_NEAR(state.parts().zeta[0].x(), 0, 1e-7);
  EXPECT_NEAR(state.parts().c[0].norm(), 0.1875, 1e-12);
}

TEST(ParticleState, OppositePosesAreNotAlikeAndNeverNegative) {
  const ParticleBounds bounds;
  ParticleParts up;
  up.eta = {0, bounds.eta_max};
  up.alpha = {bounds.alpha_max, 0};
  up.c = {Eigen::Vector2d(bounds.c_max, 0), Eigen::Vector2d(bounds.c_max, 0)};
  auto down = up;
  down.eta = -up.eta;
  down.alpha = {0, bounds.alpha_max};
  down.c = {-up.c[0], -up.c[1]};
  EXPECT_EQ(similarity(ParticleState(up, bounds), ParticleState(down, bounds)), 0);
}

TEST(ParticleState, TheSimilarityIsTheCosineOfTheAngle) {
  std::mt19937 random(4);
  for (int k = 0; k < 100; ++k) {
    const auto a = test::random_particles(random);
    const auto b = test::random_particles(random);
    using Psi = Eigen::Map<const Eigen::Matrix<double, kParticleValues, 1>>;
    const Psi x(a.psi().data());
    const Psi y(b.psi().data());
    EXPECT_NEAR(similarity(a, b), std::max(0.0, x.normalized().dot(y.normalized())), 1e-14);
    EXPECT_NEAR(mirror_similarity(a, b), similarity(mirrored(a), b), 1e-14);
  }
}

TEST(ParticleBounds, AreRefusedByNameWhereTheyAreNoLengths) {
  EXPECT_NO_THROW(ParticleBounds{}.validate());
  for (const double wrong :
       {0.0, -1.0, 1000.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    try {
      ParticleBounds{.c_max = wrong}.validate();
      ADD_FAILURE() << wrong;
    } catch (const Error& e) {
      EXPECT_EQ(e.fault(), Fault::kUsage);
      EXPECT_EQ(e.where(), "particles.c_max");
    }
    EXPECT_THROW(ParticleBounds{.alpha_max = wrong}.validate(), Error);
    EXPECT_THROW(ParticleBounds{.eta_max = wrong}.validate(), Error);
  }
}

}  // namespace
}  // namespace choreo::body
