// SPDX-License-Identifier: Apache-2.0
// How a span is written, and which frames it takes.
#include "pipeline/frame_selection.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/frames.hpp"

namespace choreo::pipeline {
namespace {

using test::error_of;
using ::testing::HasSubstr;
using namespace std::chrono_literals;

constexpr auto kNoFrame = std::numeric_limits<std::uint64_t>::max();

TEST(ParseSpan, SecondsAreTimesWithOrWithoutAUnit) {
  const auto check = [](std::string_view text, Nanoseconds from, Nanoseconds to) {
    const auto span = parse_span(text);
    EXPECT_EQ(span.from, from) << text;
    EXPECT_EQ(span.to, to) << text;
    EXPECT_EQ(span.first_frame, 1u) << text;
    EXPECT_EQ(span.last_frame, kNoFrame) << text;
    EXPECT_EQ(span.every, 1u) << text;
  };
  check("1.5:3", 1500ms, 3s);
  check("0:10s", 0s, 10s);
  check("500ms:1min", 500ms, 60s);
  check("1min:", 60s, Nanoseconds::max());
  check(":2.25", 0s, 2250ms);
  check("0:1h", 0s, 3600s);
}

TEST(ParseSpan, FramesCountFromOneAndHaveBothEndsIn) {
  const auto check = [](std::string_view text, std::uint64_t first, std::uint64_t last) {
    const auto span = parse_span(text);
    EXPECT_EQ(span.first_frame, first) << text;
    EXPECT_EQ(span.last_frame, last) << text;
    EXPECT_EQ(span.from, 0s) << text;
    EXPECT_EQ(span.to, Nanoseconds::max()) << text;
  };
  check("1f:468f", 1, 468);
  check("7f:7f", 7, 7);
  check("10f:", 10, kNoFrame);
  check(":20f", 1, 20);
  check("1f:9223372036854775807f", 1, 9223372036854775807u);
}

TEST(ParseSpan, WhatIsNoSpanIsRefusedWithItsText) {
  for (const auto* bad : {"",
                          ":",
                          "1",
                          "1:2:3",
                          "::",
                          "a:b",
                          "1:b",
                          "-1:2",
                          "1:-2",
                          "1f:2",
                          "1:2f",
                          "0f:3f",
                          "-1f:3f",
                          "f:3f",
                          "1f:f",
                          "1.5f:3f",
                          "1f:99999999999999999999f",
                          "nan:1",
                          "0:inf",
                          "0:1e400",
                          "0:1001h",
                          " 1:2",
                          "1:2 ",
                          "1: 2",
                          "1s :2s",
                          "0x1:0x2",
                          "1,5:3"}) {
    const auto error = error_of([&] { (void)parse_span(bad); });
    ASSERT_TRUE(error) << bad;
    EXPECT_EQ(error->fault(), Fault::kUsage) << bad;
    EXPECT_THAT(error->what(), HasSubstr("span \"" + std::string(bad) + "\"")) << bad;
    EXPECT_THAT(error->hint(), HasSubstr("1f:468f")) << bad;
  }
  EXPECT_THAT(error_of([] { (void)parse_span("1f:2"); })->what(), HasSubstr("mixes seconds and frames"));
}

TEST(ParseSpan, AnEmptySpanIsRefused) {
  for (const auto* bad : {"3:1.5", "2:2", "0:0", ":0", "9f:8f", "1s:1000ms"}) {
    const auto error = error_of([&] { (void)parse_span(bad); });
    ASSERT_TRUE(error) << bad;
    EXPECT_THAT(error->what(), HasSubstr("ends before it begins")) << bad;
  }
}

TEST(FrameSelection, ASpanInSecondsIsHalfOpen) {
  const auto span = parse_span("1:2");
  EXPECT_TRUE(span.before(1, 999'999'999ns));
  EXPECT_FALSE(span.before(1, 1s));
  EXPECT_FALSE(span.past(1, 1'999'999'999ns));
  EXPECT_TRUE(span.past(1, 2s));
}

TEST(FrameSelection, ASpanInFramesHasBothEndsIn) {
  const auto span = parse_span("3f:5f");
  EXPECT_TRUE(span.before(2, 0s));
  EXPECT_FALSE(span.before(3, 0s));
  EXPECT_FALSE(span.past(5, 1000h));
  EXPECT_TRUE(span.past(6, 0s));
}

TEST(FrameSelection, WithoutASpanEveryFrameIsTaken) {
  const FrameSelection all;
  for (const auto time : {Nanoseconds(0), Nanoseconds(1000h)}) {
    EXPECT_FALSE(all.before(1, time));
    EXPECT_FALSE(all.past(1'000'000'000, time));
  }
}

}  // namespace
}  // namespace choreo::pipeline
