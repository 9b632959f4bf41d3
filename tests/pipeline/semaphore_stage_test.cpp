// SPDX-License-Identifier: Apache-2.0
// What the stage keeps of signs: all, or those of a history.
#include "pipeline/stages/semaphore_stage.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "recognition/signaller.hpp"

namespace choreo::pipeline {
namespace {

using namespace std::chrono_literals;
using Signs = std::vector<recognition::HeldSign>;

// Shows signs to a stage, for a second each; the same sign always alike.
class Showing {
 public:
  explicit Showing(SemaphoreStage& stage) : stage_(stage) {}

  void sign(Nanoseconds from, std::string_view name) {
    auto& shown = shown_[std::string(name)];
    if (!shown) shown = test::seen(body::semaphore_pose(body::semaphore(name).value()), {}, chance_);
    for (auto t = from; t <= from + 1s; t += 200ms) {
      Observation o;
      o.time = t;
      o.particles = shown;
      stage_.process(o);
      told_.insert(told_.end(), o.signal->ended.begin(), o.signal->ended.end());
      text_ = o.signal->text;
    }
  }
  [[nodiscard]] const Signs& told() const { return told_; }        // As they ended.
  [[nodiscard]] const std::string& text() const { return text_; }  // As the last frame had it.

 private:
  SemaphoreStage& stage_;
  std::mt19937_64 chance_{3};
  std::map<std::string, std::optional<body::ParticleState>> shown_;
  Signs told_;
  std::string text_;
};

std::vector<std::pair<std::string_view, double>> names_and_ends(const Signs& signs) {
  std::vector<std::pair<std::string_view, double>> all;
  for (const auto& sign : signs) all.emplace_back(sign.sign, sign.to);
  return all;
}

// Somebody who faces the camera, as a look sees them: straight arms, a torso of 100 pixels.
vision::PersonLook pointing(const body::SemaphoreSign& sign) {
  using Name = vision::PersonPointName;
  vision::PersonLook look;
  const auto put = [&](Name name, cv::Point2d at) { look.points[static_cast<std::size_t>(name)] = {at, 0, 0.95, 1}; };
  const auto along = [](int position, double length) {
    const double angle = position * std::numbers::pi / 4;
    return cv::Point2d(-std::sin(angle), std::cos(angle)) * length;
  };
  put(Name::kRightShoulder, {175, 100});
  put(Name::kRightElbow, cv::Point2d(175, 100) + along(sign.right, 50));
  put(Name::kRightWrist, cv::Point2d(175, 100) + along(sign.right, 95));
  put(Name::kLeftShoulder, {225, 100});
  put(Name::kLeftElbow, cv::Point2d(225, 100) + along(sign.left, 50));
  put(Name::kLeftWrist, cv::Point2d(225, 100) + along(sign.left, 95));
  put(Name::kRightHip, {185, 200});
  put(Name::kLeftHip, {215, 200});
  look.metres[static_cast<std::size_t>(Name::kNose)] = {0, 0, -0.1};
  return look;
}

// Live: sixty frames a second, ten looks, each known four frames later.
TEST(SemaphoreStage, ALetterIsKnownAFifthOfASecondAfterItsHoldTimeIsOver) {
  const auto rest = *body::semaphore("REST"), letter = *body::semaphore("R");
  for (int phase = 0; phase < 6; ++phase) {
    SemaphoreStage stage({}, {}, ReadsSigns::kOfLooks);
    std::shared_ptr<const PersonSighting> person;
    std::optional<double> known;
    const double shown = 1 + phase / 60.0;
    for (int frame = 0; frame < 180 && !known; ++frame) {
      Observation o;
      o.time = from_seconds(frame / 60.0);
      o.picture = cv::Mat(300, 400, CV_8UC3);
      if (frame % 6 == 4) {
        o.looked = from_seconds((frame - 4) / 60.0);
        person = std::make_shared<PersonSighting>(
            PersonSighting{{}, *o.looked, {}, {}, pointing((frame - 4) / 60.0 < shown ? rest : letter)});
      }
      o.person = person;
      stage.process(o);
      EXPECT_TRUE(o.signal->of_looks);
      if (o.signal->held && o.signal->held->sign == "R") known = frame / 60.0;
    }
    ASSERT_TRUE(known);
    EXPECT_LE(*known, shown + recognition::SemaphoreOptions{}.hold_s + 0.2) << phase;
    EXPECT_GE(*known, shown + recognition::SemaphoreOptions{}.hold_s) << phase;
  }
}

TEST(SemaphoreStage, BetweenLooksNothingIsNewAndWhereNobodyIsSeenASignEnds) {
  SemaphoreStage stage({}, {}, ReadsSigns::kOfLooks);
  const auto at = [&](double time_s, bool look, bool seen) {
    Observation o;
    o.time = from_seconds(time_s);
    o.picture = cv::Mat(300, 400, CV_8UC3);
    if (look) o.looked = o.time;
    const auto shown = pointing(*body::semaphore("R"));
    if (seen) o.person = std::make_shared<PersonSighting>(PersonSighting{{}, o.time, {}, {}, shown});
    stage.process(o);
    return *o.signal;
  };
  for (int k = 0; k <= 10; ++k) at(0.1 * k, true, true);
  const auto between = at(1.05, false, true);
  ASSERT_TRUE(between.held);
  EXPECT_EQ(between.held->sign, "R");
  EXPECT_NEAR(between.held->to, 1, 1e-9);
  EXPECT_EQ(between.text, "R");
  EXPECT_TRUE(at(1.1, true, false).held) << "a look away";
  const auto gone = at(1.6, true, false);
  EXPECT_FALSE(gone.held);
  ASSERT_EQ(gone.ended.size(), 1U);
  EXPECT_NEAR(gone.ended[0].from, 0, 1e-9);
  EXPECT_NEAR(gone.ended[0].to, 1, 1e-9);
}

TEST(SemaphoreStage, InARunOfDaysTheSignsOfTheHistoryAreKeptAndNoneThatAreOlder) {
  // A letter every ten minutes; digits from the first sign on, which is forgotten on the first day.
  constexpr std::string_view kLetters = "ABCDEFGHIK";
  constexpr std::string_view kDigits = "1234567890";
  constexpr auto kHistory = 1h;
  SemaphoreStage stage({}, {}, ReadsSigns::kOfParticles, kHistory);
  Showing showing(stage);
  showing.sign(0s, "NUMERALS");
  std::string shown;
  Nanoseconds now{0};
  for (int i = 0; i < 2 * 24 * 6; ++i) {
    now = (i + 1) * 10min;
    showing.sign(now, kLetters.substr(std::size_t(i) % 10, 1));
    shown += kDigits[std::size_t(i) % 10];
    ASSERT_LE(stage.signs().size(), 7u) << "as many as an hour has";
    ASSERT_EQ(showing.text(), shown.substr(shown.size() - std::min<std::size_t>(shown.size(), 256)))
        << "what is shown does not depend on the history";
  }
  stage.finish();
  // Each was told as it ended, but the last, which ended with the run.
  auto all = names_and_ends(showing.told());
  const auto kept = names_and_ends(stage.signs());
  ASSERT_FALSE(kept.empty());
  all.push_back(kept.back());
  EXPECT_EQ(all.size(), 2 * 24 * 6 + 1);
  EXPECT_EQ(stage.ended(), all.size());
  EXPECT_EQ(stage.letters(), all.size());
  const double since = to_seconds(now + 1s - kHistory);
  const auto first = std::find_if(all.begin(), all.end(), [&](const auto& sign) { return sign.second >= since; });
  EXPECT_EQ(kept, (std::vector(first, all.end()))) << "what is within the history is complete";
  EXPECT_EQ(stage.text(), shown.substr(shown.size() - kept.size()));
  ASSERT_TRUE(stage.since());
  EXPECT_NEAR(*stage.since(), since, 1e-6);
}

TEST(SemaphoreStage, WithoutAHistoryEverySignIsKept) {
  SemaphoreStage stage({}, {}, ReadsSigns::kOfParticles);
  Showing showing(stage);
  std::string shown;
  for (int i = 0; i < 20; ++i) {
    const std::string letter(1, "ABCD"[i % 4]);
    showing.sign((i + 1) * 24h, letter);
    shown += letter;
  }
  stage.finish();
  EXPECT_EQ(stage.signs().size(), 20u);
  EXPECT_EQ(stage.text(), shown);
  EXPECT_FALSE(stage.since());
}

TEST(SemaphoreStage, WithinItsHistoryNothingIsForgotten) {
  SemaphoreStage stage({}, {}, ReadsSigns::kOfParticles, 10min);
  Showing showing(stage);
  showing.sign(1s, "A");
  showing.sign(9min, "B");
  stage.finish();
  EXPECT_EQ(stage.signs().size(), 2u);
  EXPECT_EQ(stage.text(), "AB");
  EXPECT_FALSE(stage.since());
}

}  // namespace
}  // namespace choreo::pipeline
