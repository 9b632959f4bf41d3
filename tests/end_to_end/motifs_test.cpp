// SPDX-License-Identifier: Apache-2.0
// The pattern of every motif and simple motion, in the Z and Z* that the program writes for a filmed performance.
#include <cmath>
#include <functional>

#include "devices/synthetic/script.hpp"
#include "end_to_end/choreoscope_run.hpp"

namespace choreo::test {
namespace {

using devices::synthetic::ScriptFacts;
using devices::synthetic::Symmetry;

// High and low are against the clip's own floor: 0 is what its least similar twentieth reaches, 1 is sameness.
constexpr double kHigh = 0.85;
constexpr double kLow = 0.65;
constexpr int kFps = 30;
constexpr int kEmpty = 15;  // Frames of empty room before the performance.

int frame_at(double seconds) { return static_cast<int>(std::lround(seconds * kFps)); }

/// The matrices of one script as the program wrote them, by frames of the performance.
class Filmed {
 public:
  explicit Filmed(const std::string& script, int seed = 2)
      : facts_(devices::synthetic::script_facts(script)), results_(run(script, seed)) {
    frames_ = static_cast<int>(results_.n) - kEmpty;
    std::vector<double> all;
    for (int a = 0; a < frames_; ++a) {
      for (int b = 0; b < a; ++b) {
        all.push_back(results_.Z(at(a), at(b)));
        all.push_back(results_.Zstar(at(a), at(b)));
      }
    }
    const auto twentieth = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 20);
    std::nth_element(all.begin(), twentieth, all.end());
    floor_ = *twentieth;
  }

  [[nodiscard]] const ScriptFacts& facts() const { return facts_; }
  [[nodiscard]] int end() const { return frames_ - 1; }
  [[nodiscard]] double floor() const { return floor_; }
  [[nodiscard]] double z(int a, int b) const { return above_floor(results_.Z(at(a), at(b))); }
  [[nodiscard]] double z_star(int a, int b) const { return above_floor(results_.Zstar(at(a), at(b))); }

 private:
  Results run(const std::string& script, int seed) const {
    const TempFolder folder;
    // Cycles show all they have in two rounds and a bit.
    const double duration = facts_.period && *facts_.period < 5 ? 2 * *facts_.period + 0.5 : facts_.duration;
    analyze_with_network("synthetic://" + script + "?size=320x240&empty=0.5&seed=" + std::to_string(seed) +
                             "&duration=" + std::to_string(duration),
                         folder / "out", {"--set", "plot.width_px=320", "--set", "plot.thumbnails=0"});
    return Results(folder / "out");
  }
  [[nodiscard]] static std::size_t at(int frame) { return static_cast<std::size_t>(frame + kEmpty); }
  [[nodiscard]] double above_floor(double similarity) const { return (similarity - floor_) / (1 - floor_); }

  ScriptFacts facts_;
  Results results_;
  int frames_ = 0;
  double floor_ = 0;
};

using Along = std::function<double(int)>;

double least(int first, int last, const Along& value) {
  double low = 1e9;
  for (int i = first; i <= last; ++i) low = std::min(low, value(i));
  return low;
}

double most(int first, int last, const Along& value) {
  return -least(first, last, [&](int i) { return -value(i); });
}

double mean(int first, int last, const Along& value) {
  double sum = 0;
  for (int i = first; i <= last; ++i) sum += value(i);
  return sum / (last - first + 1);
}

/// Expects a line of the plot to be bright: high on the whole, and broken nowhere. Single points may lie lower, where
/// the rounded centroids of two equal poses differ by a pixel.
void expect_bright(int first, int last, const Along& value, const char* what) {
  ASSERT_GT(last - first, 5) << what;
  EXPECT_GT(mean(first, last, value), kHigh) << what;
  EXPECT_GT(least(first, last, value), kLow) << what;
}

/// The opposite: dim on the whole, and bright nowhere.
void expect_dark(int first, int last, const Along& value, const char* what) {
  EXPECT_LT(mean(first, last, value), kLow) << what;
  EXPECT_LT(most(first, last, value), kHigh) << what;
}

/// Lines perpendicular to the axis in Z or Z*: the brightest that reaches `reach` to each side, whatever its turn.
double brightest_perpendicular(int reach, int end, const std::function<double(int, int)>& value) {
  return most(reach, end - reach,
              [&](int turn) { return least(0, reach, [&](int s) { return value(turn - s, turn + s); }); });
}

bool is_one_of(const std::string& name, std::initializer_list<const char*> names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// What a motif must not show tells it from its neighbours.
void expect_absences(const Filmed& m) {
  const auto& f = m.facts();
  if (is_one_of(f.name, {"symmetric-cycle", "asymmetric-cycle", "anti-phase", "butterfly", "walking", "limp"})) {
    const int reach = frame_at(*f.period) / 2;
    const auto z = [&](int a, int b) { return m.z(a, b); };
    const auto z_star = [&](int a, int b) { return m.z_star(a, b); };
    EXPECT_LT(brightest_perpendicular(reach, m.end(), z), kLow) << "a one-way loop never runs backwards";
    EXPECT_LT(brightest_perpendicular(reach, m.end(), z_star), kLow) << "nor backwards in the mirror";
  }
  if (is_one_of(f.name, {"asymmetric-cycle", "asymmetric-palindrome", "limp", "strike"})) {
    const auto parallel = [&](int shift) {
      return least(0, m.end() - shift, [&](int t) { return m.z_star(t, t + shift); });
    };
    EXPECT_LT(most(0, frame_at(*f.period) - 1, parallel), kLow) << "it never meets its mirror image";
  }
  if (f.name == "strike") {
    const int impact = frame_at(*f.turn);
    const auto change = [&](int t) { return 1 - m.z(t, t + 3); };
    // The arm is raised slowly and falls fast.
    EXPECT_GT(change(impact - 3), 2 * most(0, impact - frame_at(f.reach) - 3, change)) << "the axis thins";
  }
}

class MotifPattern : public ::testing::TestWithParam<std::string> {};

TEST_P(MotifPattern, IsInTheMatricesOfTheProgram) {
  const Filmed m(GetParam());
  const auto& f = m.facts();
  const int end = m.end();
  const auto around = [&](double turn) { return std::min({frame_at(f.reach), frame_at(turn), end - frame_at(turn)}); };
  const auto diagonal = [&](int t) { return m.z_star(t, t); };
  if (f.symmetry == Symmetry::kAlways) {
    EXPECT_GT(least(0, end, diagonal), kHigh) << "the axis is white";
  } else if (f.symmetry == Symmetry::kNever) {
    expect_dark(0, end, diagonal, "the axis is red");
  }
  if (f.still) {
    EXPECT_GT(least(0, end, [&](int a) { return least(a, end, [&](int b) { return m.z(a, b); }); }), kHigh)
        << "a block";
  } else {
    EXPECT_LT(least(0, end, [&](int t) { return m.z(0, t); }), kLow) << "nothing moves";
  }
  if (f.period) {
    const int period = frame_at(*f.period);
    if (period < end)
      expect_bright(
          0, end - period, [&](int t) { return m.z(t, t + period); }, "red or grey parallel");
  }
  if (f.mirror_shift) {
    const int shift = frame_at(*f.mirror_shift);
    expect_bright(
        0, end - shift, [&](int t) { return m.z_star(t, t + shift); }, "cyan parallel");
  }
  if (f.turn) {
    const int turn = frame_at(*f.turn);
    expect_bright(
        0, around(*f.turn), [&](int s) { return m.z(turn - s, turn + s); }, "perpendicular");
  }
  if (f.mirror_turn) {
    const int turn = frame_at(*f.mirror_turn);
    expect_bright(
        0, around(*f.mirror_turn), [&](int s) { return m.z_star(turn - s, turn + s); }, "cyan perpendicular");
    EXPECT_GT(diagonal(turn), kHigh) << "a white spot where it passes its mirror image";
  }
  if (f.same) {
    const int a = frame_at(f.same->first);
    const int b = frame_at(f.same->second);
    EXPECT_GT(m.z(a, b), kHigh) << "a spot";
    EXPECT_LT(most(a + kFps, b - kFps, [&](int t) { return m.z(a, t); }), kLow) << "low in between";
  }
  if (f.mirrored) {
    const int a = frame_at(f.mirrored->first);
    const int b = frame_at(f.mirrored->second);
    EXPECT_GT(m.z_star(a, b), kHigh) << "a cyan spot";
    EXPECT_LT(m.z(a, b), kLow) << "not red as well";
    EXPECT_LT(std::max(diagonal(a), diagonal(b)), kLow) << "neither is symmetric";
  }
  if (f.repeated) {
    const int a = frame_at(f.repeated->first);
    const int b = frame_at(f.repeated->second);
    expect_bright(
        0, frame_at(f.length), [&](int s) { return m.z(a + s, b + s); }, "parallel");
  }
  expect_absences(m);
}

INSTANTIATE_TEST_SUITE_P(Every, MotifPattern,
                         ::testing::Values("stillness", "state-repetition", "path-repetition", "palindrome",
                                           "symmetric-path", "reflected-state", "symmetric-cycle", "asymmetric-cycle",
                                           "symmetric-palindrome", "asymmetric-palindrome", "anti-phase",
                                           "anti-palindrome", "strike", "butterfly", "jumping-jacks", "jogging",
                                           "walking", "limp", "side-kicks"),
                         [](const auto& name) {
                           auto text = name.param;
                           std::replace(text.begin(), text.end(), '-', '_');
                           return text;
                         });

}  // namespace
}  // namespace choreo::test
