// SPDX-License-Identifier: Apache-2.0
// Whether single postures are read as the signs that they show, and others as none.
#include "recognition/semaphore_templates.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.hpp"
#include "recognition/signaller.hpp"

namespace choreo::recognition {
namespace {

using body::semaphore_signs;
using test::anybody;
using test::seen;
using test::signalled;
using test::Signaller;
using test::uniform;

// Arms that both point to one side: one of them reaches across, and either may.
bool either_way(const body::SemaphoreSign& s) {
  return s.left != 0 && s.right != 0 && s.left != 4 && s.right != 4 && (s.left < 4) == (s.right < 4);
}

struct Tally {
  int right = 0, none = 0, wrong = 0;
  std::map<std::string, std::map<std::string, int>> confused;  // shown, read
};

Tally tally(const SemaphoreTemplates& templates, double severity, int people, const body::ParticleBounds& bounds = {}) {
  Tally t;
  std::mt19937_64 chance(11);
  for (const auto& sign : semaphore_signs()) {
    for (int k = 0; k < people; ++k) {
      auto who = anybody(chance, severity);
      who.swapped = either_way(sign) && k % 2 == 1;
      const auto reading = templates.read(seen(signalled(sign, who, chance), who, chance, bounds));
      ++(reading.sign == sign.name ? t.right : reading.sign ? t.wrong : t.none);
      if (reading.sign != sign.name) ++t.confused[std::string(sign.name)][std::string(reading.sign.value_or("none"))];
    }
  }
  return t;
}

std::string table(const Tally& t) {
  std::string text = "right " + std::to_string(t.right) + ", none " + std::to_string(t.none) + ", wrong " +
                     std::to_string(t.wrong) + "\n";
  for (const auto& [shown, all] : t.confused) {
    text += shown + ":";
    for (const auto& [read, count] : all) text += " " + read + " " + std::to_string(count);
    text += "\n";
  }
  return text;
}

class SemaphoreTemplatesTest : public ::testing::Test {
 protected:
  static const SemaphoreTemplates& templates() {
    static const SemaphoreTemplates kTemplates;
    return kTemplates;
  }
  std::mt19937_64 chance_{5};
};

TEST_F(SemaphoreTemplatesTest, EverySignOfAPerfectSignallerIsReadWhateverTheSleeve) {
  for (const double sleeve : {0.0, 0.1, 0.25, 0.33, 0.45, 0.52, 0.58, 0.66, 0.73}) {
    for (const auto& sign : semaphore_signs()) {
      for (const bool swapped : {false, true}) {
        if (swapped && !either_way(sign)) continue;
        Signaller who;
        who.sleeve = sleeve;
        who.swapped = swapped;
        const auto state = seen(signalled(sign, who, chance_), who, chance_);
        const auto reading = templates().read(state);
        EXPECT_EQ(reading.sign.value_or("none"), sign.name) << "sleeve " << sleeve << " swapped " << swapped;
        EXPECT_NE(reading.runner_up, sign.name);
        const auto similarities = templates().match(unit_psi(state), state).similarity;
        EXPECT_GE(std::ranges::max(similarities), 0.97) << sign.name << " sleeve " << sleeve;
      }
    }
  }
}

TEST_F(SemaphoreTemplatesTest, PeopleWhoDifferInEverythingALittleAreReadAlmostAlways) {
  const auto t = tally(templates(), 0.6, 60);
  RecordProperty("confusion", table(t));
  EXPECT_GE(t.right, 0.985 * 29 * 60) << table(t);
  EXPECT_LE(t.wrong, 0.003 * 29 * 60) << table(t);
}

TEST_F(SemaphoreTemplatesTest, CarelessPeopleSeenBadlyAreReadSeldomWrong) {
  const auto t = tally(templates(), 1, 60);
  EXPECT_GE(t.right, 0.90 * 29 * 60) << table(t);
  EXPECT_LE(t.wrong, 0.02 * 29 * 60) << table(t);
}

TEST_F(SemaphoreTemplatesTest, AFaceThatIsFoundFifteenPerCentTooWideOrNarrowChangesNothing) {
  for (const double face : {0.85, 1.15}) {
    for (const auto& sign : semaphore_signs()) {
      Signaller who;
      who.face = face;
      EXPECT_EQ(templates().read(seen(signalled(sign, who, chance_), who, chance_)).sign.value_or("none"), sign.name);
    }
  }
}

TEST_F(SemaphoreTemplatesTest, StatesOfCalibratedBoundsAreReadByTemplatesOfTheseBounds) {
  // A body that is a quarter larger against its face.
  const body::ParticleBounds bounds{3.75 * 1.25, 0.1875 * 1.25 * 1.25, 4.8 * 1.25};
  const SemaphoreTemplates calibrated({}, bounds);
  for (const auto& sign : semaphore_signs()) {
    Signaller who;
    who.body = 1.25;
    EXPECT_EQ(calibrated.read(seen(signalled(sign, who, chance_), who, chance_, bounds)).sign.value_or("none"),
              sign.name);
  }
}

TEST_F(SemaphoreTemplatesTest, AMirroredCameraShowsMirroredSignsUnlessItIsSaidToBeMirrored) {
  const SemaphoreTemplates selfie({.mirrored = true});
  for (const auto& sign : semaphore_signs()) {
    const Signaller who;
    const auto state = mirrored(seen(signalled(sign, who, chance_), who, chance_));
    EXPECT_EQ(selfie.read(state).sign.value_or("none"), sign.name);
    const auto partner =
        body::semaphore_at(body::mirrored_position(sign.left), body::mirrored_position(sign.right)).value();
    EXPECT_EQ(templates().read(state).sign.value_or("none"), partner.name);
  }
}

TEST_F(SemaphoreTemplatesTest, FoldedHandsAreRest) {
  auto pose = body::semaphore_pose(body::semaphore("REST").value());
  for (auto& arm : pose.arm) arm = {-22, 12, 0, 8};
  const Signaller who;
  const auto state = seen(pose, who, chance_);
  ASSERT_TRUE(state.joined());
  EXPECT_EQ(templates().read(state).sign.value_or("none"), "REST");
}

TEST_F(SemaphoreTemplatesTest, FlagsBeyondTheHandsAreReadWhereTheBoundsReachThem) {
  const body::ParticleBounds bounds{5.6, 0.1875, 6.6};
  const SemaphoreTemplates templates({}, bounds);
  for (const auto& sign : semaphore_signs()) {
    TemplateVariant variant;
    variant.flag = 0.06;
    variant.size = 1.07;
    const auto state = template_state(sign, variant, bounds);
    EXPECT_EQ(templates.read(state).sign.value_or("none"), sign.name);
  }
}

TEST_F(SemaphoreTemplatesTest, ArmsThatAreBentByARightAngleShowNoSign) {
  int read = 0;
  constexpr int kPostures = 1000;
  for (int k = 0; k < kPostures; ++k) {
    const auto who = anybody(chance_, 0.6);
    body::Pose pose;
    for (auto& arm : pose.arm) arm = {uniform(chance_, 0, 180), uniform(chance_, 0, 30), uniform(chance_, -90, 90), 90};
    if (templates().read(seen(body::grounded(pose), who, chance_)).sign) ++read;
  }
  EXPECT_LE(read, kPostures / 50);
}

TEST_F(SemaphoreTemplatesTest, TwoArmsAtOneHeightAndNoSignAreNone) {
  // Every pair of positions but the signs' is taken by no sign: both arms at 2, for one, or both at 4.
  for (const int position : {1, 2, 3, 4, 5, 6, 7}) {
    ASSERT_FALSE(body::semaphore_at(position, position));
    const auto reading = templates().read(template_state({"", position, position}, {}));
    EXPECT_FALSE(reading.sign) << position << " read as " << reading.sign.value_or("");
    EXPECT_GT(reading.confidence, 0);
    EXPECT_FALSE(reading.runner_up.empty());
  }
}

TEST_F(SemaphoreTemplatesTest, WithoutAStateThereIsSurelyNoSign) {
  const auto reading = templates().read(std::optional<body::ParticleState>());
  EXPECT_FALSE(reading.sign);
  EXPECT_EQ(reading.confidence, 1);
  EXPECT_TRUE(reading.runner_up.empty());
}

TEST_F(SemaphoreTemplatesTest, ConfidenceFallsAsTheArmsGoFromOneSignToTheNext) {
  double before = 2;
  for (const double degrees : {0.0, 6.0, 12.0, 17.0}) {
    auto pose = body::semaphore_pose(body::semaphore("B").value());
    pose.arm[body::kRight].abduction += degrees;
    const auto reading = templates().read(seen(pose, Signaller{}, chance_));
    ASSERT_EQ(reading.sign.value_or("none"), "B") << degrees;
    EXPECT_LE(reading.confidence, before);
    EXPECT_LE(reading.confidence, 1);
    before = reading.confidence;
  }
  EXPECT_LT(before, 0.98);
}

TEST(SemaphoreOptionsTest, RefusesWhatIsOutOfRangeAndWhatIsNoNumber) {
  const auto refused = [](auto change) {
    SemaphoreOptions options;
    change(options);
    EXPECT_THROW(options.validate(), Error);
    EXPECT_THROW(SemaphoreTemplates{options}, Error);
  };
  refused([](auto& o) { o.least_similarity = 0.4; });
  refused([](auto& o) { o.least_similarity = 1; });
  refused([](auto& o) { o.margin = -0.01; });
  refused([](auto& o) { o.hysteresis = 0.6; });
  refused([](auto& o) { o.hold_s = 0; });
  refused([](auto& o) { o.still_widths_s = 51; });
  refused([](auto& o) { o.bridge_s = -1; });
  refused([](auto& o) { o.word_gap = std::numeric_limits<double>::quiet_NaN(); });
  EXPECT_NO_THROW(SemaphoreOptions{}.validate());
}

}  // namespace
}  // namespace choreo::recognition
