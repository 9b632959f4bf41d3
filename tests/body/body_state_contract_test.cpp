// SPDX-License-Identifier: Apache-2.0
// What every representation of a body must keep, written once (MATH.md, 1). A new representation joins by a
// specialisation of `Examples` and its name in `Representations`.
#include "body/body_state.hpp"

#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "body/mask_state.hpp"
#include "body/particle_state.hpp"
#include "support/drawn_masks.hpp"
#include "support/particles.hpp"

namespace choreo::body {
namespace {

/// Example states: any() of all kinds, also degenerate ones; symmetric() of mirror-symmetric bodies.
template <typename State>
struct Examples;

template <>
struct Examples<MaskState> {
  static std::vector<MaskState> any() {
    std::mt19937 random(11);
    std::vector<MaskState> states;
    states.emplace_back(test::mask_of({"#"}));
    states.emplace_back(test::mask_of({"##"}));
    states.emplace_back(test::mask_of({"#.", "##"}));
    for (int k = 0; k < 24; ++k) {
      states.emplace_back(test::random_mask(random, {3 + 5 * k % 70, 2 + 7 * k % 40}, 0.1 + 0.035 * k));
    }
    return states;
  }
  static std::vector<MaskState> symmetric() {
    std::mt19937 random(12);
    std::vector<MaskState> states;
    for (int width = 1; width < 70; width += 3) {
      cv::Mat mask = test::random_mask(random, {width, 9}, 0.3);
      cv::Mat flipped;
      cv::flip(mask, flipped, 1);
      states.emplace_back(cv::Mat(mask | flipped));
    }
    return states;
  }
};

template <>
struct Examples<ParticleState> {
  static std::vector<ParticleState> any() {
    std::mt19937 random(13);
    const ParticleBounds bounds;
    std::vector<ParticleState> states;
    ParticleParts parts;
    states.emplace_back(parts, bounds);  // All in one point: the face.
    parts.alpha = {0, 1};
    states.emplace_back(parts, bounds);
    parts.c = {Eigen::Vector2d(0.1, 0.1), Eigen::Vector2d(0.1, 0.1)};
    parts.alpha = {0, 0};
    states.emplace_back(parts, bounds);  // Joined.
    for (int k = 0; k < 30; ++k) states.push_back(test::random_particles(random));
    return states;
  }
  static std::vector<ParticleState> symmetric() {
    std::mt19937 random(14);
    std::vector<ParticleState> states;
    for (int k = 0; k < 30; ++k) states.push_back(test::symmetric_particles(random));
    return states;
  }
};

template <typename State>
class BodyStateContract : public ::testing::Test {
 protected:
  static_assert(BodyState<State>);
  std::vector<State> states = Examples<State>::any();
};

using Representations = ::testing::Types<MaskState, ParticleState>;
TYPED_TEST_SUITE(BodyStateContract, Representations);

TYPED_TEST(BodyStateContract, AStateIsExactlyLikeItself) {
  for (const auto& a : this->states) EXPECT_EQ(similarity(a, a), 1.0);
}

TYPED_TEST(BodyStateContract, BothSimilaritiesLieBetweenZeroAndOne) {
  for (const auto& a : this->states) {
    for (const auto& b : this->states) {
      EXPECT_GE(similarity(a, b), 0.0);
      EXPECT_LE(similarity(a, b), 1.0);
      EXPECT_GE(mirror_similarity(a, b), 0.0);
      EXPECT_LE(mirror_similarity(a, b), 1.0);
    }
  }
}

TYPED_TEST(BodyStateContract, BothSimilaritiesAreSymmetricToTheLastBit) {
  for (const auto& a : this->states) {
    for (const auto& b : this->states) {
      EXPECT_EQ(similarity(a, b), similarity(b, a));
      EXPECT_EQ(mirror_similarity(a, b), mirror_similarity(b, a));
    }
  }
}

TYPED_TEST(BodyStateContract, MirroringTwiceGivesTheSameState) {
  for (const auto& a : this->states) {
    const auto twice = mirrored(mirrored(a));
    EXPECT_EQ(similarity(twice, a), 1.0);
    for (const auto& b : this->states) {
      EXPECT_EQ(similarity(twice, b), similarity(a, b));
      EXPECT_EQ(mirror_similarity(twice, b), mirror_similarity(a, b));
    }
  }
}

TYPED_TEST(BodyStateContract, AStateAndItsMirrorImageAreMirrorImages) {
  for (const auto& a : this->states) {
    EXPECT_NEAR(mirror_similarity(a, mirrored(a)), 1.0, 1e-12);
    EXPECT_NEAR(similarity(mirrored(a), mirrored(a)), 1.0, 1e-12);
  }
}

TYPED_TEST(BodyStateContract, ASymmetricBodyIsItsOwnMirrorImage) {
  for (const auto& a : Examples<TypeParam>::symmetric()) {
    EXPECT_NEAR(mirror_similarity(a, a), 1.0, 1e-12);
    EXPECT_NEAR(similarity(a, mirrored(a)), 1.0, 1e-12);
    for (const auto& b : this->states) EXPECT_GE(mirror_similarity(a, b), 0.0);
  }
}

TYPED_TEST(BodyStateContract, NotEverythingIsAlikeAndNotEverythingIsSymmetric) {
  bool unlike = false;
  bool asymmetric = false;
  for (const auto& a : this->states) {
    asymmetric = asymmetric || mirror_similarity(a, a) < 0.9;
    for (const auto& b : this->states) unlike = unlike || similarity(a, b) < 0.5;
  }
  EXPECT_TRUE(unlike);
  EXPECT_TRUE(asymmetric);
}

}  // namespace
}  // namespace choreo::body
