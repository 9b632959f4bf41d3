// SPDX-License-Identifier: Apache-2.0
// Reading a stream of particle states, or of looks at the arms: what is a letter, when it begins and ends, and what is
// none.
#include "recognition/semaphore_reader.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "recognition/arm_sign_reader.hpp"
#include "recognition/semaphore_speller.hpp"
#include "recognition/sign_readers.hpp"
#include "recognition/signaller.hpp"

namespace choreo::recognition {
namespace {

using body::semaphore;
using test::Signaller;

struct Key {
  double seconds;
  std::string_view sign;
};

// Somebody who goes through signs: at every key's time the arms are there, in between they move on evenly.
template <class Way>
class Stream {
 public:
  explicit Stream(std::vector<Key> keys, Signaller who = {}, SemaphoreOptions options = {})
      : keys_(std::move(keys)), who_(who), reader_(options) {}

  Stream& rate(double fps) {
    fps_ = fps;
    return *this;
  }
  Stream& blind(double from, double to) {
    blind_from_ = from;
    blind_to_ = to;
    return *this;
  }
  // No frame comes.
  Stream& stalled(double from, double to) {
    stalled_from_ = from;
    stalled_to_ = to;
    return *this;
  }

  std::vector<HeldSign> read() {
    std::vector<HeldSign> all;
    std::mt19937_64 chance(3);
    for (int f = 0; f / fps_ <= keys_.back().seconds; ++f) {
      const double t = f / fps_;
      if (t > stalled_from_ && t < stalled_to_) continue;
      std::optional<typename Way::Seen> arms;
      if (t < blind_from_ || t >= blind_to_) arms = Way::see(pose_at(t), who_, chance);
      for (auto& sign : reader_.add(t, arms).ended) all.push_back(sign);
    }
    for (auto& sign : reader_.finish()) all.push_back(sign);
    return all;
  }

 private:
  [[nodiscard]] body::Pose pose_at(double t) const {
    std::size_t k = 0;
    while (k + 2 < keys_.size() && keys_[k + 1].seconds <= t) ++k;
    const auto pose = [&](std::size_t i) { return body::semaphore_pose(sign_of(keys_[i].sign)); };
    const double share = (t - keys_[k].seconds) / (keys_[k + 1].seconds - keys_[k].seconds);
    return body::blended(pose(k), pose(k + 1), std::clamp(share, 0.0, 1.0));
  }
  static body::SemaphoreSign sign_of(std::string_view name) {
    if (name == "UP") return {"UP", 4, 4};
    return semaphore(name).value();
  }

  std::vector<Key> keys_;
  Signaller who_;
  typename Way::Reader reader_;
  double fps_ = 30;
  double blind_from_ = 1e9, blind_to_ = 1e9;
  double stalled_from_ = 1e9, stalled_to_ = 1e9;
};

std::string names(const std::vector<HeldSign>& signs) {
  std::string all;
  for (const auto& s : signs) {
    if (s.sign != "REST") all += (all.empty() ? "" : " ") + std::string(s.sign);
  }
  return all;
}

template <class Way>
class SignReaders : public ::testing::Test {};
TYPED_TEST_SUITE(SignReaders, test::WaysToRead, test::WayNames);

TYPED_TEST(SignReaders, OneHeldSignIsOneSignHoweverLong) {
  const auto signs =
      Stream<TypeParam>({{0, "REST"}, {1, "REST"}, {1.5, "B"}, {31.5, "B"}, {32, "REST"}, {33, "REST"}}).read();
  ASSERT_EQ(signs.size(), 3U);
  EXPECT_EQ(names(signs), "B");
  EXPECT_NEAR(signs[1].from, 1.5, 0.4);
  EXPECT_NEAR(signs[1].to, 31.5, 0.3);
  EXPECT_GT(signs[1].confidence, 0.95);
  EXPECT_EQ(signs[1].runner_up == "A" || signs[1].runner_up == "C" || signs[1].runner_up == "S", true)
      << signs[1].runner_up;
}

TYPED_TEST(SignReaders, ASignMustBeHeld) {
  EXPECT_EQ(
      names(Stream<TypeParam>({{0, "REST"}, {1, "REST"}, {1.4, "B"}, {1.6, "B"}, {2, "REST"}, {3, "REST"}}).read()),
      "");
  EXPECT_EQ(
      names(Stream<TypeParam>({{0, "REST"}, {1, "REST"}, {1.4, "B"}, {2.4, "B"}, {2.8, "REST"}, {3, "REST"}}).read()),
      "B");
}

TYPED_TEST(SignReaders, MovementThroughSignsDoesNotSpell) {
  // From REST by A, B and C to D, and through H, S, CANCEL: at 45 degrees a second and more.
  EXPECT_EQ(names(Stream<TypeParam>({{0, "D"}, {4, "REST"}, {8, "D"}, {10, "REST"}, {11, "D"}, {11.5, "REST"}}).read()),
            "");
  EXPECT_EQ(names(Stream<TypeParam>({{0, "REST"}, {1, "Z"}, {2, "B"}, {3, "T"}, {4, "V"}, {5, "REST"}}).read()), "");
}

TYPED_TEST(SignReaders, TheSameLetterTwiceNeedsAnotherPostureInBetween) {
  EXPECT_EQ(names(Stream<TypeParam>({{0, "B"}, {2, "B"}, {2.4, "REST"}, {2.5, "REST"}, {2.9, "B"}, {5, "B"}}).read()),
            "B B");
  // A look away, a twitch of the arms: still one.
  EXPECT_EQ(names(Stream<TypeParam>({{0, "B"}, {5, "B"}}).blind(2, 2.3).read()), "B");
  EXPECT_EQ(names(Stream<TypeParam>({{0, "B"}, {5, "B"}}).blind(2, 3).read()), "B B");
}

TYPED_TEST(SignReaders, FrameRateAndNoiseChangeNothing) {
  std::mt19937_64 chance(9);
  const std::vector<Key> keys = {{0, "REST"}, {1, "REST"}, {1.5, "H"},    {3, "H"},      {3.5, "E"}, {5, "E"},
                                 {5.5, "L"},  {7, "L"},    {7.5, "REST"}, {7.8, "REST"}, {8.3, "L"}, {9.8, "L"}};
  for (const double fps : {10.0, 25.0, 60.0, 120.0}) {
    EXPECT_EQ(names(Stream<TypeParam>(keys).rate(fps).read()), "H E L L") << fps;
    const auto who = test::anybody(chance, 0.5);
    if (fps > 60) continue;  // Costs most, and noise matters least.
    EXPECT_EQ(names(Stream<TypeParam>(keys, who).rate(fps).read()), "H E L L") << fps << " sleeve " << who.sleeve;
  }
}

TYPED_TEST(SignReaders, FewFramesWithoutAStateAreBridgedAndAHiddenArmIsNoLetter) {
  EXPECT_EQ(names(Stream<TypeParam>({{0, "K"}, {3, "K"}}).blind(1.5, 1.6).read()), "K");
  EXPECT_EQ(names(Stream<TypeParam>({{0, "K"}, {3, "K"}}).blind(0, 3).read()), "");
}

TYPED_TEST(SignReaders, SlowFramesAreNoTimeWithoutAState) {
  const std::vector<Key> keys = {{0, "REST"}, {4, "REST"}, {4.5, "H"},   {9, "H"},     {9.5, "E"},  {14, "E"},
                                 {14.5, "L"}, {19, "L"},   {20, "REST"}, {24, "REST"}, {24.5, "L"}, {29, "L"}};
  for (const double fps : {1.0, 2.0, 2.5, 5.0})
    EXPECT_EQ(names(Stream<TypeParam>(keys).rate(fps).read()), "H E L L") << fps;
}

TYPED_TEST(SignReaders, BridgingNothingReadsWhatIsSeenAllTheTime) {
  for (const double bridge_s : {0.0, 0.05}) {
    SemaphoreOptions options;
    options.bridge_s = bridge_s;
    for (const double fps : {10.0, 30.0}) {
      const std::vector<Key> keys = {{0, "B"}, {3, "B"}, {3.5, "K"}, {6, "K"}};
      EXPECT_EQ(names(Stream<TypeParam>(keys, {}, options).rate(fps).read()), "B K") << bridge_s << " " << fps;
      EXPECT_EQ(names(Stream<TypeParam>(keys, {}, options).rate(fps).blind(1.5, 1.65).read()), "B B K")
          << bridge_s << " " << fps;
    }
  }
}

TYPED_TEST(SignReaders, AGapInTheFramesEndsASign) {
  const std::vector<Key> keys = {{0, "B"}, {12, "B"}};
  const auto signs = Stream<TypeParam>(keys).stalled(3, 8).read();
  ASSERT_EQ(names(signs), "B B");
  EXPECT_NEAR(signs[0].to, 3, 0.05);
  EXPECT_GE(signs[1].from, 8);
  EXPECT_EQ(names(Stream<TypeParam>(keys).stalled(3, 3.9).read()), "B") << "a hiccup";
  SemaphoreOptions patient;
  patient.bridge_s = 5;
  EXPECT_EQ(names(Stream<TypeParam>(keys, {}, patient).stalled(3, 8).read()), "B");
}

TYPED_TEST(SignReaders, ErrorIsThreeTimesUpAndDownAndSpellsNothing) {
  for (const double way : {0.3, 0.5, 0.7}) {
    std::vector<Key> keys = {{0, "REST"}, {1, "REST"}};
    double t = 1.4;
    for (int k = 0; k < 4; ++k) {
      keys.push_back({t, "N"});
      keys.push_back({t + way, "U"});
      t += 2 * way;
    }
    keys.push_back({t, "N"});
    keys.push_back({t + 0.4, "REST"});
    keys.push_back({t + 1.4, "REST"});
    const auto signs = Stream<TypeParam>(keys).read();
    EXPECT_EQ(names(signs), "ERROR") << way;
    for (const auto& s : signs) {
      if (s.sign != kError) continue;
      EXPECT_NEAR(s.from, 1.3, 0.35);
      EXPECT_NEAR(s.to, t, 0.35);
    }
  }
}

TYPED_TEST(SignReaders, AttentionSwingsOverheadAndSpellsNothing) {
  std::vector<Key> keys = {{0, "REST"}, {1, "REST"}, {1.8, "U"}};
  double t = 1.8;
  for (int k = 0; k < 4; ++k) {
    keys.push_back({t + 0.4, "UP"});
    keys.push_back({t + 0.8, "U"});
    t += 0.8;
  }
  keys.push_back({t + 0.8, "REST"});
  keys.push_back({t + 2, "REST"});
  EXPECT_EQ(names(Stream<TypeParam>(keys).read()), "ATTENTION");
}

TYPED_TEST(SignReaders, TwoSwingsAreNoMovementSign) {
  EXPECT_EQ(
      names(Stream<TypeParam>({{0, "REST"}, {0.5, "N"}, {1, "U"}, {1.5, "N"}, {2, "U"}, {2.8, "REST"}, {4, "REST"}})
                .read()),
      "");
}

TYPED_TEST(SignReaders, ArmsThatGoDownToRestEveryTimeAreNoErrorSign) {
  std::vector<Key> keys;
  for (int k = 0; k < 8; ++k) keys.push_back({0.6 * k, k % 2 == 0 ? "REST" : "U"});
  EXPECT_EQ(names(Stream<TypeParam>(keys).read()), "");
}

TYPED_TEST(SignReaders, WhatIsHeldIsToldWhileItIsHeld) {
  typename TypeParam::Reader reader;
  const Signaller who;
  std::mt19937_64 chance(1);
  const auto arms = TypeParam::see(body::semaphore_pose(semaphore("R").value()), who, chance);
  double first = -1;
  for (int f = 0; f < 60; ++f) {
    const auto step = reader.add(f / 30.0, arms);
    EXPECT_EQ(step.now.sign.value_or("none"), "R");
    if (step.held && first < 0) first = f / 30.0;
    if (step.held) {
      EXPECT_NEAR(step.held->to, f / 30.0, 1e-9);
    }
  }
  EXPECT_GT(first, 0.49);
  EXPECT_LT(first, 0.9);
  // The same moment again is not looked at.
  EXPECT_FALSE(reader.add(59 / 30.0, std::nullopt).now.sign);
  EXPECT_TRUE(reader.add(59 / 30.0, std::nullopt).held);
  EXPECT_EQ(reader.finish().size(), 1U);
  EXPECT_TRUE(reader.finish().empty());
}

TEST(SemaphoreReader, AMirroredCameraIsASetting) {
  SemaphoreOptions options;
  options.mirrored = true;
  SemaphoreReader reader(options);
  const Signaller who;
  std::mt19937_64 chance(1);
  const auto state = mirrored(test::seen(body::semaphore_pose(semaphore("A").value()), who, chance));
  for (int f = 0; f < 60; ++f) (void)reader.add(f / 30.0, state);
  EXPECT_EQ(names(reader.finish()), "A");
}

}  // namespace
}  // namespace choreo::recognition
