// SPDX-License-Identifier: Apache-2.0
#include "devices/device_time.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace choreo::devices {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Nanoseconds kFrame = milliseconds(40);
constexpr Nanoseconds kBoot = seconds(5000);  // The host's clock where the device's says 0.

TEST(DeviceClock, TakesTheQuickestArrivalForTheTruth) {
  DeviceClock clock;
  Nanoseconds last{0};
  for (int k = 0; k < 200; ++k) {
    const auto device = k * kFrame;
    const auto late = milliseconds(2 + (k * 7) % 15);  // 2 ms at best.
    last = clock.host_time(device, kBoot + device + late);
  }
  EXPECT_NEAR(to_seconds(last - (kBoot + 199 * kFrame)), 0.002, 0.003);
}

TEST(DeviceClock, OneLateArrivalMovesNoTime) {
  DeviceClock clock;
  auto before = clock.host_time(Nanoseconds{0}, kBoot + milliseconds(2));
  for (int k = 1; k < 50; ++k) {
    const auto late = k == 30 ? milliseconds(500) : milliseconds(2);
    const auto now = clock.host_time(k * kFrame, kBoot + k * kFrame + late);
    EXPECT_NEAR(to_seconds(now - before), 0.04, 2e-4) << k;
    before = now;
  }
}

TEST(DeviceClock, FollowsAClockThatRunsSlow) {
  DeviceClock clock;
  double worst = 0;
  for (int k = 0; k < 90000; ++k) {  // An hour.
    const auto true_time = k * kFrame;
    const auto device = Nanoseconds(std::llround(double(true_time.count()) * (1 - 1e-4)));
    const auto host = clock.host_time(device, kBoot + true_time + milliseconds(2));
    worst = std::max(worst, std::abs(to_seconds(host - kBoot - true_time) - 0.002));
  }
  EXPECT_LT(worst, 0.001);
}

TEST(DeviceClock, FollowsAClockThatRunsFast) {
  DeviceClock clock;
  Nanoseconds host{0};
  for (int k = 0; k < 90000; ++k) {
    host = clock.host_time(Nanoseconds(std::llround(double((k * kFrame).count()) * (1 + 1e-4))), kBoot + k * kFrame);
  }
  EXPECT_NEAR(to_seconds(host - (kBoot + 89999 * kFrame)), 0, 0.001);
}

TEST(DeviceClock, StampsACenturyFromNowAreAJumpLikeAnyOther) {
  DeviceClock clock;
  constexpr auto kCentury = Nanoseconds{100LL * 366 * 24 * 3600 * 1'000'000'000};  // As libav_time lets through.
  auto arrival = kBoot;
  for (const auto device : {kCentury, -kCentury, kCentury, Nanoseconds{0}, -kCentury}) {
    EXPECT_EQ(clock.host_time(device, arrival), arrival);
    arrival += kFrame;
  }
}

TEST(DeviceClock, TheHostsOwnStampsAreTakenAsTheyAre) {
  DeviceClock clock(true);
  for (int k = 0; k < 10; ++k) {
    const auto made = kBoot + k * kFrame;
    EXPECT_EQ(clock.host_time(made, made + milliseconds(1 + k)), made);
  }
}

TEST(DeviceClock, StampsThatCannotBeTheHostsAreMapped) {
  DeviceClock clock(true);
  EXPECT_EQ(clock.host_time(Nanoseconds{0}, kBoot), kBoot);
  EXPECT_EQ(clock.host_time(kFrame, kBoot + kFrame), kBoot + kFrame);
}

TEST(DeviceClock, ACounterThatWrapsGoesOnWhereItWas) {
  DeviceClock clock;
  const Nanoseconds wrap = seconds(71);
  Nanoseconds before{0};
  for (int k = 0; k < 4000; ++k) {
    const auto now = clock.host_time((k * kFrame) % wrap, kBoot + k * kFrame + milliseconds(3));
    if (k > 0) {
      EXPECT_NEAR(to_seconds(now - before), 0.04, 0.002) << k;
    }
    before = now;
  }
}

TEST(DeviceClock, TimesAreStrictlyIncreasingWhateverTheDeviceSays) {
  DeviceClock clock;
  Nanoseconds before{-1};
  const int said[] = {0, 40, 40, 39, 1000000, 5, 5, 5, 80, 2000000000, 3};
  for (std::size_t k = 0; k < std::size(said); ++k) {
    const auto now = clock.host_time(milliseconds(said[k]), kBoot + milliseconds(10 * int(k)));
    EXPECT_GT(now, before) << k;
    before = now;
  }
}

TEST(FrameCounter, BeginsAtZeroAndShowsGaps) {
  FrameCounter counter;
  EXPECT_EQ(counter.next(17), 0U);
  EXPECT_EQ(counter.next(18), 1U);
  EXPECT_EQ(counter.next(21), 4U);
}

TEST(FrameCounter, WrapsAround) {
  FrameCounter counter;
  EXPECT_EQ(counter.next(0xfffffffe), 0U);
  EXPECT_EQ(counter.next(0xffffffff), 1U);
  EXPECT_EQ(counter.next(1), 3U);
}

TEST(FrameCounter, OneThatGoesBackOrFarAheadBeganAnew) {
  FrameCounter counter;
  EXPECT_EQ(counter.next(500), 0U);
  EXPECT_EQ(counter.next(3), 1U);
  EXPECT_EQ(counter.next(4), 2U);
  EXPECT_EQ(counter.next(0x80000000), 3U);
  EXPECT_EQ(counter.next(0x80000000), 4U) << "the same number twice is another frame all the same";
}

TEST(FrameCounter, WhatWasLostWhileTheDeviceWasAwayIsAGap) {
  FrameCounter counter;
  EXPECT_EQ(counter.next(0), 0U);
  EXPECT_EQ(counter.next(1), 1U);
  counter.reopened();
  EXPECT_EQ(counter.next(0), 3U);
  EXPECT_EQ(counter.next(1), 4U);
}

}  // namespace
}  // namespace choreo::devices
