// SPDX-License-Identifier: Apache-2.0
// The scripts of the synthetic performer as states: what is spelled, and what dances are read as.
#include <algorithm>
#include <string>

#include <gtest/gtest.h>

#include "devices/synthetic/script.hpp"
#include "recognition/semaphore_speller.hpp"
#include "recognition/sign_readers.hpp"

namespace choreo::recognition {
namespace {

using devices::synthetic::Script;
using devices::synthetic::ScriptOptions;

template <class Way>
std::string spelled(const ScriptOptions& script_options, const test::Signaller& who, double fps) {
  const Script script("semaphore", script_options);
  typename Way::Reader reader;
  SemaphoreSpeller speller;
  std::mt19937_64 chance(script_options.seed);
  for (int f = 0; f / fps < script.duration(); ++f) {
    auto pose = *script.pose_at(f / fps);
    for (auto& arm : pose.arm) {
      arm.elbow += who.bend;
      arm.flexion += who.forward;
    }
    for (const auto& sign : reader.add(f / fps, Way::see(pose, who, chance)).ended) speller.add(sign);
  }
  for (const auto& sign : reader.finish()) speller.add(sign);
  return speller.text();
}

template <class Way>
class SemaphoreScript : public ::testing::Test {};
TYPED_TEST_SUITE(SemaphoreScript, test::WaysToRead, test::WayNames);

TYPED_TEST(SemaphoreScript, IsSpelledWithWordsDoubleLettersNumeralsAndCorrections) {
  for (const double rate : {6.0, 12.0, 30.0}) {
    ScriptOptions options;
    options.text = "ZOO 42 BX!Y";
    options.letters_per_minute = rate;
    EXPECT_EQ(spelled<TypeParam>(options, {}, 15), "ZOO 42 BY") << rate;
  }
}

TYPED_TEST(SemaphoreScript, IsSpelledByPeopleWhoDifferInEverythingALittle) {
  std::mt19937_64 chance(77);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    ScriptOptions options;
    options.seed = seed;
    options.text = "THE QUICK BROWN FOX";
    const auto who = test::anybody(chance, 0.8);
    EXPECT_EQ(spelled<TypeParam>(options, who, 10), "THE QUICK BROWN FOX") << "sleeve " << who.sleeve;
  }
}

// Signs but REST that are read in 200 seconds of a script by every seed.
template <class Way>
std::string false_signs(const std::string& name, std::uint64_t seeds = 3) {
  constexpr double kFps = 15;
  std::string read;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    ScriptOptions options;
    options.seed = seed;
    const Script script(name, options);
    std::mt19937_64 chance(seed);
    const auto who = test::anybody(chance, 0.4);
    typename Way::Reader reader;
    const auto take = [&](const std::vector<HeldSign>& signs) {
      for (const auto& s : signs) {
        if (s.sign != "REST") read += std::string(s.sign) + " ";
      }
    };
    for (int f = 0; f / kFps < 200; ++f) {
      take(reader.add(f / kFps, Way::see(*script.pose_at(f / kFps), who, chance)).ended);
    }
    take(reader.finish());
  }
  return read;
}

template <class Way>
class SemaphoreDance : public ::testing::Test {};
TYPED_TEST_SUITE(SemaphoreDance, test::WaysToRead, test::WayNames);

TYPED_TEST(SemaphoreDance, DancesAreReadAsNoSignInTenMinutesEach) {
  for (const auto* dance : {"jumping-jacks", "jogging", "walking", "butterfly", "limp", "side-kicks",
                            "asymmetric-cycle", "symmetric-cycle", "anti-palindrome"}) {
    EXPECT_EQ(false_signs<TypeParam>(dance), "") << dance;
  }
}

TYPED_TEST(SemaphoreDance, IdleMovementShowsLessThanOneLetterInTenMinutes) {
  // Improvised arms stop near a sign now and then, long enough to be read: so in forty minutes.
  const auto read = false_signs<TypeParam>("idle", 12);
  EXPECT_LT(std::count(read.begin(), read.end(), ' '), 4) << read;
}

TYPED_TEST(SemaphoreDance, WhoReallyRestsInASignsPostureShowsIt) {
  // At its end this script stays in a posture with the arms at 6 and 1: M.
  const auto read = false_signs<TypeParam>("path-repetition");
  EXPECT_EQ(read, "M M M ");
}

}  // namespace
}  // namespace choreo::recognition
