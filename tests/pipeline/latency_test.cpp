// SPDX-License-Identifier: Apache-2.0
// Percentiles of durations: near the truth from nanoseconds to hours, and exact at the top.
#include "pipeline/latency.hpp"

#include <algorithm>
#include <cstdint>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace choreo::pipeline {
namespace {

using namespace std::chrono_literals;

TEST(LatencyHistogram, WithoutDurationsIsAllZero) {
  const auto latency = LatencyHistogram().summary();
  EXPECT_EQ(latency.count, 0u);
  EXPECT_EQ(latency.p50, 0ns);
  EXPECT_EQ(latency.p999, 0ns);
  EXPECT_EQ(latency.max, 0ns);
}

TEST(LatencyHistogram, OneDurationIsEveryPercentile) {
  for (const Nanoseconds duration : {0ns, 1ns, 127ns, 128ns, Nanoseconds(33ms), Nanoseconds(1h)}) {
    LatencyHistogram histogram;
    histogram.add(duration);
    const auto latency = histogram.summary();
    EXPECT_EQ(latency.count, 1u);
    EXPECT_EQ(latency.p50, duration);
    EXPECT_EQ(latency.p999, duration);
    EXPECT_EQ(latency.max, duration);
  }
}

TEST(LatencyHistogram, PercentilesOfAThousandDifferentDurations) {
  LatencyHistogram histogram;
  for (int i = 1000; i >= 1; --i) histogram.add(i * 1ms);
  const auto latency = histogram.summary();
  const auto near = [](Nanoseconds value, Nanoseconds truth) {
    EXPECT_GE(value, truth);
    EXPECT_LE(to_seconds(value), to_seconds(truth) * 1.016);
  };
  near(latency.p50, 500ms);
  near(latency.p99, 990ms);
  near(latency.p999, 999ms);
  EXPECT_EQ(latency.max, 1000ms);
}

TEST(LatencyHistogram, OneSlowFrameInAThousandIsSeenByTheHighestPercentileAlone) {
  LatencyHistogram histogram;
  for (int i = 0; i < 998; ++i) histogram.add(1ms);
  histogram.add(1s);
  histogram.add(1s);
  const auto latency = histogram.summary();
  EXPECT_LT(latency.p99, 1017us);
  EXPECT_GE(latency.p999, 1s);
}

TEST(LatencyHistogram, NeverExceedsTheLargestAndIsNeverMoreThanASixtyFourthTooHigh) {
  for (std::int64_t duration = 1; duration > 0 && duration < (std::int64_t{1} << 61); duration = duration * 5 / 3 + 1) {
    LatencyHistogram histogram;
    histogram.add(Nanoseconds(duration));
    histogram.add(Nanoseconds(duration * 2));
    const auto p50 = histogram.summary().p50.count();
    EXPECT_GE(p50, duration);
    EXPECT_LE(double(p50 - duration), double(duration) / 64.0) << duration;
  }
}

TEST(LatencyHistogram, IsReadWhileAnotherThreadAddsToIt) {
  constexpr std::uint64_t kAll = 1000;
  LatencyHistogram histogram;
  const std::jthread adds([&] {
    for (std::uint64_t k = 0; k < kAll; ++k) histogram.add(1us);
  });
  for (std::uint64_t seen = 0; seen < kAll;) {
    const auto now = histogram.summary().count;
    ASSERT_GE(now, seen);
    seen = now;
  }
}

TEST(LatencyHistogram, AClockThatWentBackCountsAsNoTime) {
  LatencyHistogram histogram;
  histogram.add(-5ms);
  EXPECT_EQ(histogram.summary().count, 1u);
  EXPECT_EQ(histogram.summary().max, 0ns);
}

}  // namespace
}  // namespace choreo::pipeline
