// SPDX-License-Identifier: Apache-2.0
// What looks at arms are worth that do not fit those about them.
#include "recognition/arm_sign_reader.hpp"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "body/semaphore_signs.hpp"

namespace choreo::recognition {
namespace {

body::ArmPoses showing(char letter) {
  const auto sign = *body::semaphore(std::string(1, letter));
  const auto straight = [](int position) { return body::ArmPose{45.0 * position, 45.0 * position, 1, 1, 0}; };
  body::ArmPoses arms;
  arms[body::kLeft] = straight(sign.left);
  arms[body::kRight] = straight(sign.right);
  return arms;
}

// One look for each letter, so many a second; what was held.
std::vector<HeldSign> read(const std::string& looks, double per_s = 10) {
  ArmSignReader reader;
  std::vector<HeldSign> all;
  for (std::size_t k = 0; k < looks.size(); ++k) {
    for (const auto& sign : reader.add(double(k) / per_s, showing(looks[k])).ended) all.push_back(sign);
  }
  for (const auto& sign : reader.finish()) all.push_back(sign);
  return all;
}

TEST(ArmSignReader, ALookUnlikeThoseAboutItWhichAreAlikeDoesNotCount) {
  // Every third look takes one arm for both.
  const auto signs = read("RRWRRWRRWRRWR");
  ASSERT_EQ(signs.size(), 1U);
  EXPECT_EQ(signs[0].sign, "R");
  EXPECT_LT(signs[0].from, 0.11);
  EXPECT_NEAR(signs[0].to, 1.2, 1e-9);
}

TEST(ArmSignReader, LooksThatDisagreeByTurnsSayNothing) { EXPECT_TRUE(read("RWRWRWRWRWRWRW").empty()); }

TEST(ArmSignReader, SeveralInARowAreAnotherPosture) {
  const auto signs = read("RRRRRRRRWWWRRRRRRRR");
  ASSERT_EQ(signs.size(), 2U);
  EXPECT_EQ(signs[0].sign, "R");
  EXPECT_NEAR(signs[0].to, 0.7, 0.11);
  EXPECT_EQ(signs[1].sign, "R");
}

TEST(ArmSignReader, AnArmHasTimeToGoAndComeBackBetweenSlowLooks) {
  EXPECT_EQ(read("RRRRRRRRWRRRRRRRR", 6).size(), 1U);
  EXPECT_EQ(read("RRRRRRRRWRRRRRRRR", 5).size(), 2U);
}

}  // namespace
}  // namespace choreo::recognition
