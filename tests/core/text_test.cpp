// SPDX-License-Identifier: Apache-2.0
#include "core/text.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"

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
  EXPECT_EQ(nearest_name("thr", names), "threshold") << "its beginning";
  EXPECT_FALSE(nearest_name("colour", names));
  EXPECT_FALSE(nearest_name("", names));
  EXPECT_FALSE(nearest_name(std::string(1 << 20, 'x'), names));
}

TEST(Text, Utf8IsToldFromWhatOnlyLooksLikeIt) {
  for (const auto* good :
       {"", "plain", "caf\xc3\xa9", "\xe2\x82\xac", "\xf0\x9f\x92\x83", "\xf4\x8f\xbf\xbf", "\xed\x9f\xbf"}) {
    EXPECT_TRUE(is_utf8(good)) << good;
  }
  // A bare continuation, a cut character, overlong forms, a surrogate, behind the last character, never a byte of it.
  for (const auto* bad : {"\x80", "\xc3", "caf\xe9", "\xe2\x82", "\xc0\x80", "\xe0\x9f\xbf", "\xf0\x8f\xbf\xbf",
                          "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xff"}) {
    EXPECT_FALSE(is_utf8(bad)) << bad;
  }
}

TEST(Text, OneLineShowsWhatWouldMoveTheCursorOrIsNoCharacter) {
  EXPECT_EQ(one_line("caf\xc3\xa9 \"x\" \\"), "caf\xc3\xa9 \"x\" \\") << "what can be printed stays";
  EXPECT_EQ(one_line("a\nb\tc\rd"), "a\\nb\\tc\\x0dd");
  EXPECT_EQ(one_line("\x1b[2J\x7f"), "\\x1b[2J\\x7f");
  EXPECT_EQ(one_line("\xff\xe9!"), "\\xff\\xe9!");
  EXPECT_EQ(one_line("\xc2\x9b"), "\\xc2\\x9b") << "the control sequence introducer in one character";
  EXPECT_EQ(one_line(std::string_view("a\0b", 3)), "a\\x00b");
}

TEST(Text, CountedIsSingularForOneAlone) {
  EXPECT_EQ(counted(0, "frame"), "0 frames");
  EXPECT_EQ(counted(1, "frame"), "1 frame");
  EXPECT_EQ(counted(26, "picture"), "26 pictures");
}

TEST(Text, ShortenedEndsBetweenCharacters) {
  EXPECT_EQ(shortened("abc", 3), "abc");
  EXPECT_EQ(shortened("abcd", 3), "abc...");
  EXPECT_EQ(shortened("ab\xc3\xa9", 3), "ab...");
  EXPECT_EQ(shortened("\xff\xff\xff\xff", 2), "\xff\xff...");
}

TEST(Error, IsOneLineWhateverTheNamesInIt) {
  const auto error = usage_error("\"a\nb\" is no film", "x\n.toml:1", "rename\nit");
  EXPECT_STREQ(error.what(), "x\\n.toml:1: \"a\\nb\" is no film");
  EXPECT_EQ(error.where(), "x\\n.toml:1");
  EXPECT_EQ(error.hint(), "rename\\nit");
  EXPECT_EQ(error.fault(), Fault::kUsage);
}

}  // namespace
}  // namespace choreo
