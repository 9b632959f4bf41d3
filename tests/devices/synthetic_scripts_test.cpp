// SPDX-License-Identifier: Apache-2.0
// What each script says of itself holds on the true masks, measured by plain loops over Z and Z*.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include <gtest/gtest.h>

#include "core/error.hpp"
#include "devices/silhouettes.hpp"
#include "devices/synthetic/performer.hpp"
#include "devices/synthetic/semaphore_script.hpp"

namespace choreo::devices::synthetic {
namespace {

using choreo::testing::Silhouette;

// Exact repetitions differ by rounded edge pixels at most; anything else in these scripts stays far below.
constexpr double kHigh = 0.985;
constexpr double kLow = 0.90;
constexpr int kFps = 30;

// The true masks of one script, by time.
class Recorded {
 public:
  explicit Recorded(const std::string& script, std::uint64_t seed = 2) {
    PerformerSettings settings;
    settings.size = {160, 120};
    settings.noise = 0;
    settings.empty = 0;
    settings.seed = seed;
    const Performer performer(script, settings);
    facts_ = performer.script().facts();
    for (int i = 0; i < performer.frame_count(); ++i) frames_.emplace_back(performer.perform(i).mask);
  }

  [[nodiscard]] const ScriptFacts& facts() const { return facts_; }
  [[nodiscard]] int frames() const { return static_cast<int>(frames_.size()); }
  [[nodiscard]] double z(int a, int b) const { return similarity(at(a), at(b)); }
  [[nodiscard]] double z_star(int a, int b) const { return mirror_similarity(at(a), at(b)); }

 private:
  [[nodiscard]] const Silhouette& at(int frame) const { return frames_.at(static_cast<std::size_t>(frame)); }

  ScriptFacts facts_;
  std::vector<Silhouette> frames_;
};

int frame_at(double seconds) { return static_cast<int>(std::lround(seconds * kFps)); }

double least(int first, int last, const std::function<double(int)>& value) {
  double low = 1;
  for (int i = first; i <= last; ++i) low = std::min(low, value(i));
  return low;
}

double most(int first, int last, const std::function<double(int)>& value) {
  double high = 0;
  for (int i = first; i <= last; ++i) high = std::max(high, value(i));
  return high;
}

class ScriptFactsHold : public ::testing::TestWithParam<std::string> {};

TEST_P(ScriptFactsHold, OnTrueMasks) {
  const Recorded r(GetParam());
  const auto& f = r.facts();
  const int end = r.frames() - 1;
  if (f.symmetry == Symmetry::kAlways) {
    EXPECT_GT(least(0, end, [&](int t) { return r.z_star(t, t); }), kHigh);
  }
  if (f.symmetry == Symmetry::kNever) {
    EXPECT_LT(most(0, end, [&](int t) { return r.z_star(t, t); }), kLow);
  }
  if (f.still) {
    EXPECT_GT(least(0, end, [&](int t) { return r.z(0, t); }), kHigh);
  } else {
    EXPECT_LT(least(0, end, [&](int t) { return r.z(0, t); }), kLow) << "nothing moves";
  }
  if (f.period) {
    const int period = frame_at(*f.period);
    EXPECT_NEAR(*f.period * kFps, period, 1e-9);
    ASSERT_LE(period, end + 1);
    EXPECT_GT(least(0, end - period, [&](int t) { return r.z(t, t + period); }), kHigh);
  }
  if (f.mirror_shift) {
    const int shift = frame_at(*f.mirror_shift);
    EXPECT_NEAR(*f.mirror_shift * kFps, shift, 1e-9);
    EXPECT_GT(least(0, end - shift, [&](int t) { return r.z_star(t, t + shift); }), kHigh);
  }
  if (f.turn) {
    const int turn = frame_at(*f.turn);
    const int reach = std::min({frame_at(f.reach), turn, end - turn});
    ASSERT_GT(reach, 5);
    EXPECT_GT(least(0, reach, [&](int s) { return r.z(turn - s, turn + s); }), kHigh);
  }
  if (f.mirror_turn) {
    const int turn = frame_at(*f.mirror_turn);
    const int reach = std::min({frame_at(f.reach), turn, end - turn});
    ASSERT_GT(reach, 5);
    EXPECT_GT(least(0, reach, [&](int s) { return r.z_star(turn - s, turn + s); }), kHigh);
  }
  if (f.same) {
    const int a = frame_at(f.same->first);
    const int b = frame_at(f.same->second);
    EXPECT_GT(r.z(a, b), kHigh);
    EXPECT_LT(most(a + kFps, b - kFps, [&](int t) { return r.z(a, t); }), kLow);
  }
  if (f.mirrored) {
    const int a = frame_at(f.mirrored->first);
    const int b = frame_at(f.mirrored->second);
    EXPECT_GT(r.z_star(a, b), kHigh);
    EXPECT_LT(r.z(a, b), kLow);
    EXPECT_LT(r.z_star(a, a), kLow);
  }
  if (f.repeated) {
    const int a = frame_at(f.repeated->first);
    const int b = frame_at(f.repeated->second);
    ASSERT_GT(frame_at(f.length), 5);
    EXPECT_GT(least(0, frame_at(f.length), [&](int s) { return r.z(a + s, b + s); }), kHigh);
  }
}

INSTANTIATE_TEST_SUITE_P(Every, ScriptFactsHold,
                         ::testing::Values("stillness", "state-repetition", "path-repetition", "palindrome",
                                           "symmetric-path", "reflected-state", "symmetric-cycle", "asymmetric-cycle",
                                           "symmetric-palindrome", "asymmetric-palindrome", "anti-phase",
                                           "anti-palindrome", "strike", "butterfly", "jumping-jacks", "jogging",
                                           "walking", "limp", "side-kicks", "idle"),
                         [](const auto& name) {
                           auto text = name.param;
                           std::replace(text.begin(), text.end(), '-', '_');
                           return text;
                         });

TEST(Scripts, OneWayCyclesNeverRunBackwards) {
  for (const auto* name : {"symmetric-cycle", "asymmetric-cycle", "anti-phase", "butterfly", "walking", "limp"}) {
    const Recorded r(name);
    const int period = frame_at(r.facts().period.value());
    // Whatever the turn, half a period around it somewhere differs, in Z and in Z*.
    for (int turn = period; turn < 2 * period; ++turn) {
      const int reach = period / 2;
      EXPECT_LT(least(0, reach, [&](int s) { return r.z(turn - s, turn + s); }), kLow) << name << " " << turn;
      EXPECT_LT(least(0, reach, [&](int s) { return r.z_star(turn - s, turn + s); }), kLow) << name << " " << turn;
    }
  }
}

TEST(Scripts, AsymmetricCyclesNeverMeetTheirMirrorImage) {
  for (const auto* name : {"asymmetric-cycle", "asymmetric-palindrome", "limp", "strike"}) {
    const Recorded r(name);
    const int period = frame_at(r.facts().period.value());
    for (int shift = 0; shift < period; ++shift) {
      EXPECT_LT(least(0, period, [&](int t) { return r.z_star(t, t + shift); }), kLow) << name << " " << shift;
    }
  }
}

TEST(Scripts, AStrikeIsFastestAtItsImpactAndSlowBeforeIt) {
  const Script script("strike", {});
  const auto step = [&](int frame) {
    const auto a = body::skeleton_of(*script.pose_at(frame / 30.0)).fingertip[body::kRight];
    const auto b = body::skeleton_of(*script.pose_at((frame + 1) / 30.0)).fingertip[body::kRight];
    return (a - b).norm();
  };
  const int impact = frame_at(*script.facts().turn);
  EXPECT_GT(step(impact - 1), 3 * step(impact - 9));
  for (int frame = 0; frame < 75; ++frame) EXPECT_LE(step(frame), std::max(step(impact - 1), step(impact)) + 1e-9);
}

TEST(Scripts, CrossingLeavesThePictureOnBothSides) {
  PerformerSettings settings;
  settings.size = {160, 120};
  settings.empty = 0;
  const Performer performer("crossing", settings);
  EXPECT_FALSE(performer.perform(0).present);
  EXPECT_FALSE(performer.perform(6 * 30).present);
  const auto there = performer.perform(3 * 30);
  const auto back = performer.perform(9 * 30);
  ASSERT_TRUE(there.present);
  ASSERT_TRUE(back.present);
  EXPECT_GT(mirror_similarity(Silhouette(there.mask), Silhouette(back.mask)), kHigh);
}

TEST(Scripts, IdleIsAnotherImprovisationForEverySeed) {
  const Recorded one("idle", 1);
  const Recorded other("idle", 3);
  EXPECT_EQ(one.frames(), other.frames());
  const Script a("idle", {.seed = 1});
  const Script b("idle", {.seed = 3});
  EXPECT_NE(body::pose_values(*a.pose_at(4)), body::pose_values(*b.pose_at(4)));
}

TEST(Scripts, NamesAreUniqueAndAnUnknownOneIsAnsweredWithTheNearest) {
  auto names = script_names();
  EXPECT_EQ(names.size(), 24u);
  std::sort(names.begin(), names.end());
  EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end());
  try {
    (void)script_facts("jumping-jack");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.fault(), Fault::kUsage);
    EXPECT_EQ(error.hint(), "did you mean \"jumping-jacks\"?");
  }
}

// How far two straight arms are from the nearest sign: the larger of their deviations, in degrees.
double distance_from_signs(const body::Skeleton& s) {
  std::array<double, 2> positions{};
  double off = 0;
  for (const auto side : {body::kLeft, body::kRight}) {
    const auto direction = [](const Eigen::Vector3d& d) { return std::atan2(-d.x(), -d.y()) * 180 / std::numbers::pi; };
    const double forearm = direction(s.fingertip[side] - s.elbow[side]);
    const double upper = direction(s.elbow[side] - s.shoulder[side]);
    // A bent arm is no sign's.
    if (std::abs(std::remainder(forearm - upper, 360)) > 40) return 180;
    const double whole = direction(s.fingertip[side] - s.shoulder[side]);
    positions[side] = std::round(whole / 45);
    off = std::max(off, std::abs(std::remainder(whole, 45)));
  }
  return std::remainder(positions[0] - positions[1], 8) == 0 ? 180 : off;
}

TEST(Scripts, DancersRestNowAndThenAndNearSignsButNeverAtOne) {
  int rests = 0, near = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Script script("dancing", {.seed = seed});
    double still = 0;
    for (double t = 0; t < 120; t += 0.1) {
      const auto now = body::skeleton_of(*script.pose_at(t));
      const auto next = body::skeleton_of(*script.pose_at(t + 0.1));
      double turned = 0;
      for (const auto side : {body::kLeft, body::kRight}) {
        const auto a = (now.fingertip[side] - now.shoulder[side]).normalized();
        const auto b = (next.fingertip[side] - next.shoulder[side]).normalized();
        turned = std::max(turned, std::acos(std::min(1.0, a.dot(b))) * 180 / std::numbers::pi);
      }
      still = turned < 2 ? still + 0.1 : 0;
      if (still < 0.25) continue;
      const double off = distance_from_signs(now);
      ASSERT_GT(off, 12) << "seed " << seed << " at " << t;
      near += off < 30;
      rests += still < 0.36;
    }
  }
  EXPECT_GT(rests, 8 * 2 * 15) << "a quarter of the postures are rests";
  EXPECT_GT(near, 8 * 2 * 15);
}

TEST(SemaphoreScript, AttentionWavesBothArmsFromThreeAndFiveUntilTheyCrossOverhead) {
  const auto signs = spelled("^", 12);
  ASSERT_EQ(signs.size(), 1u);
  EXPECT_EQ(signs[0].sign.name, "ATTENTION");
  EXPECT_TRUE(signs[0].moves);
  const Script script("semaphore", {.text = "^"});
  int crossings = 0;
  bool crossed = false;
  for (double t = signs[0].from; t <= signs[0].to + 1e-9; t += 1.0 / 30) {
    const auto pose = *script.pose_at(t);
    const auto s = body::skeleton_of(pose);
    for (const auto side : {body::kLeft, body::kRight}) {
      EXPECT_GE(pose.arm[side].abduction, 135 - 1e-9);
      EXPECT_EQ(pose.arm[side].elbow, 0);
    }
    const bool now = s.fingertip[body::kLeft].x() < s.fingertip[body::kRight].x();
    crossings += now && !crossed;
    crossed = now;
  }
  EXPECT_EQ(crossings, 4);
  EXPECT_NEAR(script.pose_at(signs[0].from)->arm[body::kLeft].abduction, 135, 1e-9);
  EXPECT_NEAR(script.pose_at(signs[0].to)->arm[body::kLeft].abduction, 135, 1e-9);
}

TEST(SemaphoreScript, ErrorRaisesAndLowersBothArmsThroughTheHorizontal) {
  const auto signs = spelled("A~B", 30);
  ASSERT_EQ(signs.size(), 3u);
  EXPECT_EQ(signs[1].sign.name, "ERROR");
  EXPECT_NEAR(signs[1].from, 2 + 0.3, 1e-9);
  EXPECT_NEAR(signs[2].from, signs[1].to + 0.3 * 2 + 0.3, 1e-9) << "lowered, at REST, and raised again";
  const Script script("semaphore", {.text = "A~B", .letters_per_minute = 30});
  int raised = 0;
  bool up = false;
  double least = 180, most = 0;
  for (double t = signs[1].from; t <= signs[1].to; t += 1.0 / 30) {
    const auto pose = *script.pose_at(t);
    EXPECT_EQ(pose.arm[body::kLeft].abduction, pose.arm[body::kRight].abduction);
    const bool now = pose.arm[body::kLeft].abduction > 90;
    raised += now && !up;
    up = now;
    least = std::min(least, pose.arm[body::kLeft].abduction);
    most = std::max(most, pose.arm[body::kLeft].abduction);
  }
  EXPECT_EQ(raised, 5);
  EXPECT_NEAR(least, 45, 1e-9);
  EXPECT_NEAR(most, 135, 1.5);
}

TEST(SemaphoreScript, SpellsLettersDigitsAndSpaces) {
  const auto names = [](std::string_view text) {
    std::string all;
    for (const auto& sign : spelled(text, 12)) all += std::string(sign.sign.name) + " ";
    return all;
  };
  EXPECT_EQ(names("Ab z"), "A B Z ");
  EXPECT_EQ(names("A10B"), "A NUMERALS A K J B ");
  EXPECT_EQ(names("#!^~"), "NUMERALS CANCEL ATTENTION ERROR ");
  for (const auto* bad : {"", "  ", "A.B", "\xc3\xa4"}) EXPECT_THROW((void)spelled(bad, 12), Error) << bad;
}

TEST(SemaphoreScript, EverySignIsHeldWithItsPoseAndRestComesBetween) {
  ScriptOptions options;
  options.text = "CAB";
  options.letters_per_minute = 20;
  const Script script("semaphore", options);
  const auto signs = spelled(options.text, options.letters_per_minute);
  ASSERT_EQ(signs.size(), 3u);
  // Three seconds a sign: up by 0.45 s, held for 1.65 s.
  EXPECT_NEAR(signs[1].from, 3.45, 1e-9);
  EXPECT_NEAR(signs[1].to, 5.1, 1e-9);
  EXPECT_NEAR(script.duration(), 9, 1e-9);
  for (const auto& s : signs) {
    const auto wanted = body::semaphore_pose(s.sign);
    for (const double t : {s.from, (s.from + s.to) / 2, s.to}) {
      const auto pose = *script.pose_at(t);
      EXPECT_DOUBLE_EQ(pose.arm[body::kRight].abduction, wanted.arm[body::kRight].abduction) << s.sign.name;
      EXPECT_DOUBLE_EQ(pose.arm[body::kLeft].abduction, wanted.arm[body::kLeft].abduction) << s.sign.name;
    }
  }
  const auto rest = body::semaphore_pose(body::semaphore("REST").value());
  EXPECT_DOUBLE_EQ(script.pose_at(2.8)->arm[body::kRight].abduction, rest.arm[body::kRight].abduction);
  EXPECT_DOUBLE_EQ(script.pose_at(0)->arm[body::kRight].abduction, rest.arm[body::kRight].abduction);
}

}  // namespace
}  // namespace choreo::devices::synthetic
