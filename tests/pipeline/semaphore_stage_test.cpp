// SPDX-License-Identifier: Apache-2.0
// What the stage keeps of signs: all, or those of a history.
#include "pipeline/stages/semaphore_stage.hpp"

#include <algorithm>
#include <chrono>
#include <map>
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
