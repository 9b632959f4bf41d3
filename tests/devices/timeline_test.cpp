// SPDX-License-Identifier: Apache-2.0
#include "devices/video_file/timeline.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace choreo::devices {
namespace {

// 40 ms a frame, 1 ms the smallest step; stamps in ms, -1 for a missing one.
std::vector<int> mended(const std::vector<int>& stamps, std::uint64_t* count = nullptr) {
  Timeline timeline(std::chrono::milliseconds(40), std::chrono::milliseconds(1));
  std::vector<int> times;
  for (const int stamp : stamps) {
    const auto given = stamp < 0 ? std::nullopt : std::optional<Nanoseconds>(std::chrono::milliseconds(stamp));
    times.push_back(static_cast<int>(timeline.next(given).count() / 1'000'000));
  }
  if (count != nullptr) *count = timeline.mended();
  return times;
}

TEST(Timeline, IncreasingStampsPassUnchanged) {
  std::uint64_t count = 9;
  EXPECT_EQ(mended({7, 8, 300, 301, 5000}, &count), (std::vector{7, 8, 300, 301, 5000}));
  EXPECT_EQ(count, 0u);
}

TEST(Timeline, MissingStampsGoOnAtTheNominalRate) {
  std::uint64_t count = 0;
  EXPECT_EQ(mended({-1, -1, -1}, &count), (std::vector{0, 40, 80}));
  EXPECT_EQ(count, 3u);
  EXPECT_EQ(mended({0, 40, -1, 120}, &count), (std::vector{0, 40, 80, 120}));
  EXPECT_EQ(count, 1u);
}

TEST(Timeline, ARepeatedStampDoesNotPushTheNextOneAside) {
  std::uint64_t count = 0;
  EXPECT_EQ(mended({0, 40, 40, 80, 120}, &count), (std::vector{0, 40, 41, 80, 120}));
  EXPECT_EQ(count, 1u);
}

TEST(Timeline, AStrayStampDoesNotPushTheNextOneAside) {
  std::uint64_t count = 0;
  EXPECT_EQ(mended({0, 40, 10, 80, 120}, &count), (std::vector{0, 40, 60, 80, 120}));
  EXPECT_EQ(count, 1u);
}

TEST(Timeline, AClockThatBeginsAnewKeepsItsVariableRate) {
  // The second part's own steps are 30 and 100 ms.
  EXPECT_EQ(mended({0, 1000, 2000, 0, 30, 130}), (std::vector{0, 1000, 2000, 2020, 2050, 2150}));
}

TEST(Timeline, WhateverTheStampsTimesIncreaseStrictly) {
  for (int seed = 1; seed < 200; ++seed) {
    unsigned state = static_cast<unsigned>(seed);
    std::vector<int> stamps;
    for (int i = 0; i < 50; ++i) {
      state = state * 1664525u + 1013904223u;
      stamps.push_back(static_cast<int>(state >> 24) - 20);
    }
    const auto times = mended(stamps);
    ASSERT_EQ(times.size(), stamps.size());
    for (std::size_t i = 1; i < times.size(); ++i)
      ASSERT_LT(times[i - 1], times[i]) << "seed " << seed << " frame " << i;
  }
}

TEST(Timeline, WithoutADeclaredRateTheSmallestStepIsTaken) {
  Timeline timeline(Nanoseconds(0), Nanoseconds(0));
  EXPECT_EQ(timeline.next(std::nullopt), Nanoseconds(0));
  EXPECT_EQ(timeline.next(std::nullopt), Nanoseconds(1));
}

}  // namespace
}  // namespace choreo::devices
