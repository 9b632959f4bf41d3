// SPDX-License-Identifier: Apache-2.0
// How signs become words.
#include "recognition/semaphore_speller.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace choreo::recognition {
namespace {

using Told = std::vector<std::pair<std::string_view, double>>;  // sign, seconds

std::string text_of(const Told& signs, const SemaphoreOptions& options = {}) {
  SemaphoreSpeller speller(options);
  double t = 0;
  for (const auto& [sign, seconds] : signs) {
    speller.add({sign, t, t + seconds, 1, {}});
    t += seconds + 0.5;
  }
  return speller.text();
}

TEST(SemaphoreSpeller, ShortRestsBetweenLettersAreNoSpacesAndLongOnesAre) {
  EXPECT_EQ(text_of({{"A", 3}, {"REST", 1}, {"A", 3}, {"REST", 3.5}, {"B", 3}}), "AA B");
}

TEST(SemaphoreSpeller, WhatIsLongDependsOnTheSignallersOwnLetters) {
  EXPECT_EQ(text_of({{"A", 0.6}, {"REST", 0.2}, {"B", 0.6}, {"REST", 0.6}, {"C", 0.6}}), "AB C");
  EXPECT_EQ(text_of({{"A", 9}, {"REST", 3}, {"B", 9}, {"REST", 9}, {"C", 9}}), "AB C");
  // Who goes from letter to letter without REST says a space by any that is as long as a letter.
  EXPECT_EQ(text_of({{"A", 2}, {"B", 2}, {"REST", 2}, {"C", 2}}), "AB C");
  SemaphoreOptions options;
  options.word_gap = 2;
  EXPECT_EQ(text_of({{"A", 2}, {"B", 2}, {"REST", 2}, {"C", 2}}, options), "ABC");
}

TEST(SemaphoreSpeller, NoSpaceBeginsOrEndsTheTextAndNoneIsDouble) {
  EXPECT_EQ(text_of({{"REST", 9}, {"A", 2}, {"REST", 9}, {"REST", 9}, {"B", 2}, {"REST", 60}}), "A B");
}

TEST(SemaphoreSpeller, AfterNumeralsLettersAreDigitsUntilJ) {
  EXPECT_EQ(
      text_of({{"A", 1}, {"NUMERALS", 1}, {"A", 1}, {"I", 1}, {"K", 1}, {"REST", 2}, {"B", 1}, {"J", 1}, {"J", 1}}),
      "A190 2J");
  EXPECT_EQ(text_of({{"NUMERALS", 1}, {"L", 1}, {"NUMERALS", 1}, {"C", 1}}), "L3");
}

TEST(SemaphoreSpeller, CancelTakesALetterAndErrorAWord) {
  EXPECT_EQ(text_of({{"A", 1}, {"B", 1}, {"CANCEL", 1}, {"C", 1}}), "AC");
  EXPECT_EQ(text_of({{"A", 1}, {"B", 1}, {"REST", 2}, {"C", 1}, {"D", 1}, {"ERROR", 3}, {"E", 1}}), "AB E");
  EXPECT_EQ(text_of({{"A", 1}, {"B", 1}, {"REST", 2}, {"ERROR", 3}, {"E", 1}}), "E");
  EXPECT_EQ(text_of({{"A", 1}, {"REST", 2}, {"C", 1}, {"CANCEL", 1}, {"D", 1}}), "A D");
  EXPECT_EQ(text_of({{"A", 1}, {"REST", 2}, {"CANCEL", 1}, {"D", 1}}), "D");
  EXPECT_EQ(text_of({{"CANCEL", 1}, {"ERROR", 3}, {"CANCEL", 1}, {"A", 1}}), "A");
}

TEST(SemaphoreSpeller, AttentionWritesNothing) {
  EXPECT_EQ(text_of({{"ATTENTION", 4}, {"A", 1}, {"ATTENTION", 4}}), "A");
}

TEST(SemaphoreSpeller, TheLetterThatIsHeldIsShownBeforeItEnds) {
  SemaphoreSpeller speller;
  speller.add({"A", 0, 1, 1, {}});
  EXPECT_EQ(speller.text_with(HeldSign{"B", 2, 2.5, 1, {}}), "AB");
  EXPECT_EQ(speller.text_with(std::nullopt), "A");
  EXPECT_EQ(speller.text(), "A");
}

TEST(SemaphoreSpeller, TheEndOfTheTextIsTheSameHoweverMuchOfItIsWanted) {
  const std::vector<Told> texts = {{},
                                   {{"A", 1}},
                                   {{"A", 1}, {"REST", 2}, {"B", 1}},
                                   {{"A", 1}, {"REST", 2}, {"B", 1}, {"C", 1}, {"D", 1}, {"REST", 2}},
                                   {{"REST", 2}, {"NUMERALS", 1}, {"A", 1}, {"B", 1}, {"C", 1}, {"D", 1}, {"E", 1}}};
  for (const auto& told : texts) {
    SemaphoreSpeller speller;
    double t = 0;
    for (const auto& [sign, seconds] : told) {
      speller.add({sign, t, t + seconds, 1, {}});
      t += seconds + 0.5;
    }
    for (const std::string_view held : {"", "A", "J", "REST", "NUMERALS", "CANCEL", "ERROR", "ATTENTION"}) {
      const auto now = held.empty() ? std::nullopt : std::optional(HeldSign{held, t, t + 2, 1, {}});
      const auto whole = speller.text_with(now);
      for (std::size_t most = 0; most < 8; ++most) {
        const auto end = whole.substr(whole.size() - std::min(whole.size(), most));
        EXPECT_EQ(speller.text_with(now, most), end) << held << " of " << speller.text() << ", " << most;
      }
    }
  }
}

TEST(SemaphoreSpeller, WhatIsKeptOfTheTextIsItsEndWhateverComes) {
  // By chance, with what takes away and what changes the meaning more often than anybody shows it.
  constexpr std::string_view kSigns[] = {"A",        "B", "C",      "K",      "Q",     "J",
                                         "NUMERALS", "J", "CANCEL", "CANCEL", "ERROR", "REST"};
  for (const std::size_t most : {0, 1, 3, 6}) {
    SemaphoreSpeller whole;
    SemaphoreSpeller kept;
    std::uint32_t chance = 1;
    for (int i = 0; i < 5000; ++i) {
      chance = chance * 1664525 + 1013904223;
      const auto sign = kSigns[(chance >> 16) % std::size(kSigns)];
      const HeldSign held{sign, 2.0 * i, 2.0 * i + 1, 1, {}};
      whole.add(held);
      kept.add(held);
      ASSERT_TRUE(whole.text().ends_with(kept.text())) << "\"" << kept.text() << "\" of " << whole.text();
      kept.keep_end(most);
      ASSERT_LE(kept.text().size(), most);
      ASSERT_TRUE(whole.text().ends_with(kept.text())) << "\"" << kept.text() << "\" of " << whole.text();
      ASSERT_FALSE(kept.text().starts_with(' '));
    }
  }
}

TEST(SemaphoreSpeller, NumeralsStayNumeralsWhereTheirSignIsForgotten) {
  SemaphoreSpeller speller;
  speller.add({"NUMERALS", 0, 1, 1, {}});
  speller.add({"A", 2, 3, 1, {}});
  speller.keep_end(0);
  EXPECT_EQ(speller.text(), "");
  speller.add({"B", 4, 5, 1, {}});
  EXPECT_EQ(speller.text(), "2");
}

}  // namespace
}  // namespace choreo::recognition
