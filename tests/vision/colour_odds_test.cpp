// SPDX-License-Identifier: Apache-2.0
#include "vision/colour_odds.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace choreo::vision {
namespace {

const cv::Vec3b kRedPixel(36, 36, 204);
const cv::Vec3b kGrey(132, 132, 132);
const cv::Vec3b kGreen(36, 204, 36);

ColourOdds odds_of_red_before_grey(float weight = 1) {
  ColourOdds odds;
  odds.add_body(kRedPixel, 100 * weight);
  odds.add_wall(kGrey, 700 * weight);
  odds.finish();
  return odds;
}

TEST(ColourOdds, AreForTheSideThatShowedTheColour) {
  const auto odds = odds_of_red_before_grey();
  EXPECT_GT(odds.log_odds(kRedPixel), 3);
  EXPECT_LT(odds.log_odds(kGrey), -3);
}

TEST(ColourOdds, OfAColourThatNeitherShowedAreEven) { EXPECT_FLOAT_EQ(odds_of_red_before_grey().log_odds(kGreen), 0); }

TEST(ColourOdds, OfAColourThatBothShowedInEqualPartsAreEven) {
  ColourOdds odds;
  odds.add_body(kRedPixel, 5);
  odds.add_body(kGrey, 5);
  odds.add_wall(kRedPixel, 80);
  odds.add_wall(kGrey, 80);
  odds.finish();
  EXPECT_NEAR(odds.log_odds(kRedPixel), 0, 1e-4);
  EXPECT_NEAR(odds.log_odds(kGrey), 0, 1e-4);
}

TEST(ColourOdds, DoNotDependOnHowManyPixelsThereWere) {
  const auto few = odds_of_red_before_grey();
  const auto many = odds_of_red_before_grey(64);
  EXPECT_NEAR(few.log_odds(kRedPixel), many.log_odds(kRedPixel), 1e-4);
  EXPECT_NEAR(few.log_odds(kGrey), many.log_odds(kGrey), 1e-4);
}

// One bin of 32^3 holds all of the body: smoothed by 1 2 1 along three axes it keeps an eighth, of 0.6 beside the 0.4
// that is uniform.
TEST(ColourOdds, AreTheRatioOfTheMixedDensities) {
  const double body = 0.6 * 32768.0 / 8.0 + 0.4;
  EXPECT_NEAR(odds_of_red_before_grey().log_odds(kRedPixel), std::log(body / 0.4), 1e-3);
}

TEST(ColourOdds, ReachNeighbouringColoursForClothIsShaded) {
  const auto odds = odds_of_red_before_grey();
  const float beside = odds.log_odds({36, 36, 212});
  EXPECT_GT(beside, 1);
  EXPECT_LT(beside, odds.log_odds(kRedPixel));
  EXPECT_FLOAT_EQ(odds.log_odds({36, 36, 228}), 0);
}

TEST(ColourOdds, WhereNothingIsKnownSayNothing) {
  ColourOdds odds;
  odds.finish();
  EXPECT_FLOAT_EQ(odds.log_odds(kRedPixel), 0);
  ColourOdds only_wall;
  only_wall.add_wall(kGrey, 9);
  only_wall.finish();
  EXPECT_LT(only_wall.log_odds(kGrey), 0);
}

TEST(ColourOdds, TheEndsOfTheScaleHaveColoursToo) {
  ColourOdds odds;
  odds.add_body({0, 0, 0}, 1);
  odds.add_wall({255, 255, 255}, 1);
  odds.finish();
  EXPECT_GT(odds.log_odds({0, 0, 0}), 3);
  EXPECT_LT(odds.log_odds({255, 255, 255}), -3);
}

}  // namespace
}  // namespace choreo::vision
