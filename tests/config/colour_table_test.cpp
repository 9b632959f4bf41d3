// SPDX-License-Identifier: Apache-2.0
#include "config/colour_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.hpp"

namespace choreo::config {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string table_refused(std::string_view text, const std::string& columns = {}) {
  try {
    (void)parse_colour_table(text, "some.csv", columns);
  } catch (const Error& error) {
    EXPECT_EQ(error.fault(), Fault::kUsage);
    return error.what();
  }
  return "nothing was refused";
}

TEST(ColourTable, WithoutNamesIsBlueGreenRedLabel) {
  const auto table = parse_colour_table("1,2,3,1\n4,5,6,2\n", "some.csv");
  ASSERT_EQ(table.bgr.size(), 2U);
  EXPECT_EQ(table.bgr[0], cv::Vec3b(1, 2, 3));
  EXPECT_EQ(table.bgr[1], cv::Vec3b(4, 5, 6));
  EXPECT_EQ(table.label, (std::vector<int>{1, 2}));
}

TEST(ColourTable, BelievesTheFirstLinesNames) {
  const auto table = parse_colour_table("Red,Green,Blue,Class\n3,2,1,0\n", "some.csv");
  EXPECT_EQ(table.bgr.at(0), cv::Vec3b(1, 2, 3));
  EXPECT_EQ(table.label.at(0), 0);
}

TEST(ColourTable, BelievesTheCommandLineMore) {
  const auto table = parse_colour_table("r,g,b,skin\n1,2,3,1\n", "some.csv", "B,G,R,label");
  EXPECT_EQ(table.bgr.at(0), cv::Vec3b(1, 2, 3));
  const auto wide = parse_colour_table("x,9.5,1,1,2,3\n", "some.csv", "-,-,label,b,g,r");
  EXPECT_EQ(wide.bgr.at(0), cv::Vec3b(1, 2, 3));
}

TEST(ColourTable, MayBeSeparatedByTabsSemicolonsOrSpaces) {
  for (const auto* text : {"1\t2\t3\t1\r\n", "1;2;3;1", " 1  2 3 1 \n\n"}) {
    EXPECT_EQ(parse_colour_table(text, "some.csv").bgr.at(0), cv::Vec3b(1, 2, 3)) << text;
  }
}

TEST(ColourTable, RefusesByLineWhatIsNoColour) {
  EXPECT_THAT(table_refused("1,2,3,1\n1,2,256,1\n"), AllOf(StartsWith("some.csv:2: "), HasSubstr("\"256\"")));
  EXPECT_THAT(table_refused("1,2,3,1\n1,-2,3,1\n"), StartsWith("some.csv:2: "));
  EXPECT_THAT(table_refused("1,2,3,1\n\n1,nan,3,1\n"), AllOf(StartsWith("some.csv:3: "), HasSubstr("\"nan\"")));
  EXPECT_THAT(table_refused("1,2,3,1\n1,2,red,1\n"), HasSubstr("\"red\" is no colour's value"));
  EXPECT_THAT(table_refused("1,2,2.5,1\n"), HasSubstr("\"2.5\""));
  EXPECT_THAT(table_refused("1,2,,1\n"), HasSubstr("\"\""));
  EXPECT_THAT(table_refused("1,2,3,skin\n"), HasSubstr("\"skin\" is no label"));
}

TEST(ColourTable, RefusesOtherColumnsThanItHas) {
  EXPECT_THAT(table_refused("1,2,3\n"), AllOf(StartsWith("some.csv:1: "), HasSubstr("3 columns instead of 4")));
  EXPECT_THAT(table_refused("1,2,3,1\n1,2,3,4,1\n"), AllOf(StartsWith("some.csv:2: "), HasSubstr("5 columns")));
  EXPECT_THAT(table_refused("b,g,label\n1,2,3\n"), HasSubstr("no column is named red"));
  EXPECT_THAT(table_refused("b,b,g,r,label\n1,2,3,4,5\n"), HasSubstr("more than one column is named blue"));
  EXPECT_THAT(table_refused("1,2,3,1\n", "B,G,R,tag"), AllOf(HasSubstr("--columns"), HasSubstr("\"tag\"")));
}

TEST(ColourTable, RefusesEmptyOnes) {
  EXPECT_THAT(table_refused(""), HasSubstr("no colour"));
  EXPECT_THAT(table_refused("b,g,r,label\n"), HasSubstr("no colour"));
  EXPECT_THROW((void)load_colour_table("/nowhere/at/all.csv"), Error);
  EXPECT_THROW((void)load_colour_table("/tmp"), Error);
}

}  // namespace
}  // namespace choreo::config
