// SPDX-License-Identifier: Apache-2.0
// Which of a depth camera's modes is taken.
#include "devices/openni2/mode_choice.hpp"

#include <vector>

#include <gtest/gtest.h>

#include "devices/fourcc.hpp"

namespace choreo::devices::openni2 {
namespace {

// As an Xtion has them; the second is of a format that is not known here.
const std::vector<Mode> kModes = {{Sensor::kColour, kRgb3, 320, 240, 60},   {Sensor::kColour, 0, 640, 480, 30},
                                  {Sensor::kColour, kUyvy, 640, 480, 30},   {Sensor::kColour, kRgb3, 640, 480, 30},
                                  {Sensor::kColour, kRgb3, 1280, 1024, 30}, {Sensor::kColour, kRgb3, 320, 240, 30}};

TEST(OpenNi2Modes, WithoutAWishIs640x480InTheFormatThatLosesLeast) { EXPECT_EQ(choose_mode(kModes, {}), 3U); }

TEST(OpenNi2Modes, AWishedSizeIsTakenExactlyOrNothing) {
  EXPECT_EQ(choose_mode(kModes, {1280, 1024, true, 0}), 4U);
  EXPECT_EQ(choose_mode(kModes, {1280, 1000, true, 0}), std::nullopt);
  EXPECT_EQ(choose_mode(kModes, {1280, 1000, false, 0}), 4U);
}

TEST(OpenNi2Modes, OfOneSizeTheNearestRateIsTaken) {
  EXPECT_EQ(choose_mode(kModes, {320, 240, true, 60}), 0U);
  EXPECT_EQ(choose_mode(kModes, {320, 240, true, 25}), 5U);
}

TEST(OpenNi2Modes, WhereNothingCanBeReadThereIsNone) {
  EXPECT_EQ(choose_mode({}, {}), std::nullopt);
  EXPECT_EQ(choose_mode(std::vector<Mode>{kModes[1]}, {}), std::nullopt);
}

}  // namespace
}  // namespace choreo::devices::openni2
