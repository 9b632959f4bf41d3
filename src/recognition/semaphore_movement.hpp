// SPDX-License-Identifier: Apache-2.0
// The two signs of semaphore that are movements: ATTENTION and ERROR.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "recognition/semaphore_templates.hpp"

namespace choreo::recognition {

inline constexpr std::string_view kAttention = "ATTENTION";
inline constexpr std::string_view kError = "ERROR";

/// A movement that is going on or has just ended.
struct Movement {
  std::string_view name;  ///< kAttention or kError.
  double from = 0;        ///< Seconds: the first time that the arms were at one of its two ends,
  double to = 0;          ///< and the last.
  double confidence = 0;  ///< Mean Z to the ends where the arms turned.
};

/// Knows a movement by the postures it goes to and fro between: both arms at 1 and 7, then at 3 and 5 (ERROR); both
/// at 3 and 5, then crossing or together at 4 (ATTENTION). Three times there and back, each way within 1.25 seconds and
/// with no other of these postures, nor REST, on the way.
/// @thread thread-bound
class MovementDetector {
 public:
  explicit MovementDetector(bool mirrored, const body::ParticleBounds& bounds = {});

  /// @param time_s  increasing.
  /// @return the movement that is over, if one is.
  std::optional<Movement> add(double time_s, const body::ParticleState& state);

  /// Says that time passed without a state.
  std::optional<Movement> pass(double time_s);

  /// The movement that is going on: three times there and back have been seen.
  [[nodiscard]] std::optional<Movement> going_on() const;

  /// Forgets what is going on and returns it.
  std::optional<Movement> finish();

 private:
  enum Station : std::size_t { kRest, kLow, kLevel, kHigh, kUp, kStations, kNowhere };

  // To and fro between two stations.
  struct Swing {
    std::string_view name;
    Station low, high;
    Station last = kNowhere;
    int ways = 0;
    double from = 0, to = 0;
    double sum = 0;   // of the best Z of every stay but the last
    double best = 0;  // of the last
  };
  [[nodiscard]] static std::optional<Movement> complete(const Swing& swing);
  static void restart(Swing& swing);
  static std::optional<Movement> visit(Swing& swing, Station station, double time_s, double z);

  struct Template {
    UnitPsi psi;
    body::ParticleState state;
    Station station;
  };
  std::vector<Template> templates_;
  std::array<Swing, 2> swings_;
};

}  // namespace choreo::recognition
