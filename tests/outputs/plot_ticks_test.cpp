// SPDX-License-Identifier: Apache-2.0
#include "outputs/plot_ticks.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace choreo::outputs {
namespace {

using testing::ElementsAre;

std::vector<std::string> labels(const TimeTicks& ticks) {
  std::vector<std::string> all;
  for (const auto& t : ticks.ticks) all.push_back(t.label);
  return all;
}

TEST(TimeTicks, StepsAreRoundForEveryLength) {
  const struct {
    double end, least, step;
    const char* unit;
  } table[] = {
      {0.03, 0.004, 0.005, "s"},
      {0.03, 0.0051, 0.01, "s"},
      {1.0, 0.1, 0.1, "s"},
      {10.0, 1.1, 2.0, "s"},
      {10.0, 2.1, 5.0, "s"},
      {100.0, 5.1, 10.0, "s"},
      {120.0, 11.0, 20.0, "s"},
      {121.0, 11.0, 20.0, "min:s"},
      {200.0, 21.0, 30.0, "min:s"},
      {600.0, 31.0, 60.0, "min:s"},
      {600.0, 61.0, 120.0, "min:s"},
      {3600.0, 301.0, 600.0, "min:s"},
      {7200.0, 301.0, 600.0, "h:min"},
      {7200.0, 601.0, 1200.0, "h:min"},
      {7200.0, 1801.0, 3600.0, "h:min"},
      {90000.0, 3601.0, 7200.0, "h:min"},
      {90000.0, 7201.0, 18000.0, "h:min"},
      {7200.0, 20.0, 20.0, "h:min:s"},
  };
  for (const auto& row : table) {
    const auto ticks = time_ticks(0.0, row.end, row.least);
    EXPECT_DOUBLE_EQ(ticks.step_s, row.step) << row.end << " " << row.least;
    EXPECT_EQ(ticks.unit, row.unit) << row.end << " " << row.least;
  }
}

TEST(TimeTicks, LabelsHaveAsManyDecimalsAsTheStepNeeds) {
  EXPECT_THAT(labels(time_ticks(0.0, 0.03, 0.01)), ElementsAre("0", "0.01", "0.02", "0.03"));
  EXPECT_THAT(labels(time_ticks(0.0, 1.04, 0.5)), ElementsAre("0", "0.5", "1.0"));
  EXPECT_THAT(labels(time_ticks(0.0, 24.9, 10.0)), ElementsAre("0", "10", "20"));
}

TEST(TimeTicks, MinutesAndHoursReadAsOnAClock) {
  EXPECT_THAT(labels(time_ticks(0.0, 150.0, 60.0)), ElementsAre("0:00", "1:00", "2:00"));
  EXPECT_THAT(labels(time_ticks(0.0, 130.0, 30.0)), ElementsAre("0:00", "0:30", "1:00", "1:30", "2:00"));
  EXPECT_THAT(labels(time_ticks(0.0, 5400.0, 1800.0)), ElementsAre("0:00", "0:30", "1:00", "1:30"));
  EXPECT_THAT(labels(time_ticks(3725.0, 3766.0, 20.0)), ElementsAre("1:02:20", "1:02:40"));
}

TEST(TimeTicks, AShortStretchOfALongRecordingKeepsItsFractions) {
  EXPECT_THAT(labels(time_ticks(179.9, 180.3, 0.2)), ElementsAre("3:00.0", "3:00.2"));
  EXPECT_THAT(labels(time_ticks(3661.0, 3661.5, 0.5)), ElementsAre("1:01:01.0", "1:01:01.5"));
  EXPECT_THAT(labels(time_ticks(239.8, 240.0, 0.1)), ElementsAre("3:59.8", "3:59.9", "4:00.0"));
}

TEST(TimeTicks, TicksAreMultiplesOfTheStepWithinTheAxis) {
  const auto ticks = time_ticks(3.7, 11.2, 2.0);
  EXPECT_THAT(labels(ticks), ElementsAre("4", "6", "8", "10"));
  EXPECT_THAT(labels(time_ticks(-3.0, 3.0, 2.0)), ElementsAre("-2", "0", "2"));
  EXPECT_THAT(labels(time_ticks(0.0, 3 * 0.1, 0.1)), ElementsAre("0", "0.1", "0.2", "0.3"));
  EXPECT_THAT(labels(time_ticks(0.0, 0.5, 1.0)), ElementsAre("0"));
}

TEST(Duration, IsSaidAsAPersonWould) {
  EXPECT_EQ(describe_duration(0.0333), "0.033 s");
  EXPECT_EQ(describe_duration(51.24), "51.2 s");
  EXPECT_EQ(describe_duration(200.0), "3 min 20 s");
  EXPECT_EQ(describe_duration(3599.6), "1 h 0 min");
  EXPECT_EQ(describe_duration(3840.0), "1 h 4 min");
}

}  // namespace
}  // namespace choreo::outputs
