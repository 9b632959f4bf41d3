// SPDX-License-Identifier: Apache-2.0
// Times that others wrote, as FFmpeg tells them.
#include "devices/media/libav.hpp"

#include <gtest/gtest.h>

namespace choreo::devices {
namespace {

constexpr std::int64_t kYear = 366LL * 24 * 3600;
constexpr AVRational kSeconds{1, 1};

TEST(LibavTime, CountsUnitsOfAnyLength) {
  EXPECT_EQ(libav_time(90000, {1, 90000}), std::chrono::seconds(1));
  EXPECT_EQ(libav_time(-3, {1, 1000}), std::chrono::milliseconds(-3));
  EXPECT_EQ(libav_time(1, {1001, 30000}), Nanoseconds(33'366'667));
}

TEST(LibavTime, TheDifferenceOfAnyTwoFits) {
  const auto latest = libav_time(100 * kYear, kSeconds);
  const auto earliest = libav_time(-100 * kYear, kSeconds);
  ASSERT_TRUE(latest && earliest);
  EXPECT_GT(*latest - *earliest, Nanoseconds(0));
  // With more it would not: 2 x 150 years are over 2^63 ns.
  EXPECT_FALSE(libav_time(150 * kYear, kSeconds));
  EXPECT_FALSE(libav_time(-150 * kYear, kSeconds));
}

TEST(LibavTime, WhatIsNoTimeIsNone) {
  EXPECT_FALSE(libav_time(AV_NOPTS_VALUE, kSeconds));
  EXPECT_FALSE(libav_time(INT64_MAX, kSeconds));
  EXPECT_FALSE(libav_time(-INT64_MAX, kSeconds));
  EXPECT_FALSE(libav_time(1, {0, 1}));
  EXPECT_FALSE(libav_time(1, {1, 0}));
}

}  // namespace
}  // namespace choreo::devices
