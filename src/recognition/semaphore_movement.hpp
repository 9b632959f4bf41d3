// SPDX-License-Identifier: Apache-2.0
// The two signs of semaphore that are movements: ATTENTION and ERROR.
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "body/arm_poses.hpp"
#include "recognition/held_sign.hpp"
#include "recognition/semaphore_templates.hpp"

namespace choreo::recognition {

inline constexpr std::string_view kAttention = "ATTENTION";
inline constexpr std::string_view kError = "ERROR";

/// Where both arms are alike: down, at 1 and 7, level, at 3 and 5, overhead, or nowhere such.
enum class Station { kRest, kLow, kLevel, kHigh, kUp, kNowhere };

struct AtStation {
  Station station = Station::kNowhere;
  double likeness = 0;  ///< 0 to 1.
};

/// Forearms that are on average below 28 degrees outwards, from 30 to 60, 65 to 115, 120 to 150, or above 152, and
/// either within 13 of that; at the ends of movements (kLow, kHigh, kUp) of straight arms. The likeness is the cosine
/// of what is between.
[[nodiscard]] AtStation station_of(const body::ArmPoses& arms);

/// By the templates of particle states.
class ParticleStations {
 public:
  explicit ParticleStations(bool mirrored, const body::ParticleBounds& bounds = {});

  /// The nearest, where Z to it is above 0.85, which is the likeness.
  [[nodiscard]] AtStation of(const body::ParticleState& state) const;

 private:
  struct Template {
    UnitPsi psi;
    body::ParticleState state;
    Station station;
  };
  std::vector<Template> templates_;
};

/// Knows a movement by the stations it goes to and fro between: kLow and kHigh (ERROR); kHigh and kUp (ATTENTION).
/// Three times there and back, each way within 1.25 seconds and with no other station but kLevel on the way.
/// @thread thread-bound
class MovementDetector {
 public:
  /// @param time_s  increasing.  @param where  nowhere where no arms are seen.
  /// @return the movement that is over, if one is: from the first time that the arms were at one of its two ends to the
  ///   last; the confidence is the mean likeness to the ends where they turned.
  std::optional<HeldSign> add(double time_s, const AtStation& where);

  /// Forgets what is going on and returns it where it was three times there and back.
  std::optional<HeldSign> finish();

 private:
  // To and fro between two stations.
  struct Swing {
    std::string_view name;
    Station low, high;
    Station last = Station::kNowhere;
    int ways = 0;
    double from = 0, to = 0;
    double sum = 0;   // of the best likeness of every stay but the last
    double best = 0;  // of the last
  };
  [[nodiscard]] static std::optional<HeldSign> complete(const Swing& swing);
  static void restart(Swing& swing);
  static std::optional<HeldSign> visit(Swing& swing, double time_s, const AtStation& where);

  std::array<Swing, 2> swings_ = {Swing{kError, Station::kLow, Station::kHigh},
                                  {kAttention, Station::kHigh, Station::kUp}};
};

}  // namespace choreo::recognition
