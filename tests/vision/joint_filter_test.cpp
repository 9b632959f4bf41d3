// SPDX-License-Identifier: Apache-2.0
#include "vision/person/joint_filter.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace choreo::vision {
namespace {

constexpr auto kNose = std::size_t(PersonPointName::kNose);
constexpr auto kHip = std::size_t(PersonPointName::kLeftHip);

// A nose at x pixels, and the hip at a hundred pixels and one metre from 0: a hundred pixels are a metre.
PersonLook nose_at(double x) {
  PersonLook look;
  for (auto& point : look.points) point.visibility = 1;
  look.points[kNose].at = {x, 0};
  look.metres[kNose] = {x / 100, 0, 0};
  look.points[kHip].at = {0, 100};
  look.metres[kHip] = {0, 1, 0};
  return look;
}

double x_of(const PersonLook& look) { return look.points[kNose].at.x; }

TEST(JointFilter, TakesHalfOfAStepWhereTheTimeIsThatOfTheCutoff) {
  JointFilter filter({1 / (2 * std::numbers::pi), 0});
  EXPECT_EQ(x_of(filter.next(nose_at(0), 0)), 0) << "the first is as it is";
  EXPECT_NEAR(x_of(filter.next(nose_at(8), 1)), 4, 1e-9);
  const auto third = filter.next(nose_at(8), 2);
  EXPECT_NEAR(x_of(third), 6, 1e-9);
  EXPECT_NEAR(third.metres[kNose].x, 0.06, 1e-9) << "in space as in the picture";
  EXPECT_EQ(third.points[kHip].at, cv::Point2d(0, 100)) << "what rests, rests";
  filter.forget();
  EXPECT_EQ(x_of(filter.next(nose_at(50), 3)), 50);
}

TEST(JointFilter, SteadiesWhatRestsAndFollowsWhatMoves) {
  const JointFilterOptions usual{1, 5};
  JointFilter rests(usual);
  JointFilter moves(usual);
  double left = 0, late = 0;
  for (int k = 0; k < 120; ++k) {
    const double noise = k % 2 == 0 ? 1 : -1;
    const double seen = x_of(rests.next(nose_at(noise), k / 30.0));
    if (k >= 60) left = std::max(left, std::abs(seen));
  }
  EXPECT_LT(left, 1 / 3.0);
  constexpr double kPixelsASecond = 300;  // Three metres.
  for (int k = 0; k < 30; ++k) {
    const double at = kPixelsASecond * k / 30;
    late = (at - x_of(moves.next(nose_at(at), k / 30.0))) / kPixelsASecond;
  }
  EXPECT_LT(late, 0.02) << "seconds";
  EXPECT_GT(late, 0);
}

}  // namespace
}  // namespace choreo::vision
