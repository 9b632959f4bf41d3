// SPDX-License-Identifier: Apache-2.0
#include "core/text.hpp"

#include <gtest/gtest.h>

namespace choreo {
namespace {

TEST(Text, NumbersMustBeWholeAndFinite) {
  EXPECT_EQ(parse_number("1.5"), 1.5);
  EXPECT_EQ(parse_number("-2e3"), -2000.0);
  for (const auto* bad : {"", " 1", "1 ", "1,5", "nan", "inf", "1e999", "0x10", "one"}) {
    EXPECT_FALSE(parse_number(bad)) << bad;
  }
}

TEST(Text, IntegersMustBeWholeAndFit) {
  EXPECT_EQ(parse_integer("-12"), -12);
  for (const auto* bad : {"", "1.0", "12a", "99999999999999999999"}) EXPECT_FALSE(parse_integer(bad)) << bad;
}

TEST(Text, EditDistanceCountsSwappedNeighboursOnce) {
  EXPECT_EQ(edit_distance("", ""), 0u);
  EXPECT_EQ(edit_distance("abc", ""), 3u);
  EXPECT_EQ(edit_distance("threshold", "treshold"), 1u);
  EXPECT_EQ(edit_distance("treshold", "rteshold"), 1u);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
}

TEST(Text, TheNearestNameIsOnlyNamedWhenSomebodyCouldHaveMeantIt) {
  const std::vector<std::string> names = {"threshold", "steps", "roi"};
  EXPECT_EQ(nearest_name("treshold", names), "threshold");
  EXPECT_EQ(nearest_name("step", names), "steps");
  EXPECT_FALSE(nearest_name("colour", names));
  EXPECT_FALSE(nearest_name("", names));
  EXPECT_FALSE(nearest_name(std::string(1 << 20, 'x'), names));
}

}  // namespace
}  // namespace choreo
