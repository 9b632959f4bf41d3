// SPDX-License-Identifier: Apache-2.0
#include "recognition/semaphore_movement.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace choreo::recognition {
namespace {

constexpr int kWays = 5;              // there, back, there, back, there: three times at either end
constexpr double kLongestWay = 1.25;  // seconds
constexpr double kNear = 0.85;        // Z from which the arms are at a station
constexpr double kEven = 0.80;        // Z* of a state with itself from which both arms do the same

}  // namespace

AtStation station_of(const body::ArmPoses& arms) {
  constexpr double kReach = 22.5;  // Degrees, half way to the next.
  constexpr double kUneven = 13;   // Between T, which stands still, and arms that cross.
  constexpr std::array kAt = {Station::kRest, Station::kLow, Station::kLevel, Station::kHigh, Station::kUp};
  const auto& left = arms[body::kLeft];
  const auto& right = arms[body::kRight];
  if (!left || !right) return {};
  for (std::size_t k = 0; k < kAt.size(); ++k) {
    const double from_right = body::turn(45.0 * double(k), right->fore);
    const double from_left = body::turn(45.0 * double(k), -left->fore);
    const double mean = (from_right + from_left) / 2;
    if (std::abs(mean) <= kReach && std::abs(from_right - mean) <= kUneven) {
      return {kAt[k], std::cos(std::max(std::abs(from_right), std::abs(from_left)) * std::numbers::pi / 180)};
    }
  }
  return {};
}

ParticleStations::ParticleStations(bool mirrored, const body::ParticleBounds& bounds) {
  struct Place {
    Station station;
    int left, right;
    double spread;
  };
  constexpr std::array<Place, 7> kPlaces = {{{Station::kRest, 0, 0, 0},
                                             {Station::kLow, 7, 1, 0},
                                             {Station::kLevel, 6, 2, 0},
                                             {Station::kHigh, 5, 3, 0},
                                             {Station::kUp, 4, 4, 0},
                                             {Station::kUp, 4, 4, 12},
                                             {Station::kUp, 4, 4, 24}}};
  for (const auto& place : kPlaces) {
    for (auto variant : template_variants()) {
      // Bent arms would blur where a movement turns.
      if (variant.bend != 0) continue;
      variant.spread = place.spread;
      variant.size *= bounds.alpha_max / body::ParticleBounds{}.alpha_max;
      const auto state = template_state({"", place.left, place.right}, variant, bounds);
      const auto shown = mirrored ? body::mirrored(state) : state;
      templates_.push_back({unit_psi(shown), shown, place.station});
    }
  }
}

AtStation ParticleStations::of(const body::ParticleState& state) const {
  const auto psi = unit_psi(state);
  const Template* nearest = nullptr;
  double best = kNear;
  for (const auto& t : templates_) {
    if (t.state.joined() != state.joined()) continue;
    double z = 0;
    for (std::size_t k = 0; k < psi.size(); ++k) z += t.psi[k] * psi[k];
    if (z > best) {
      best = z;
      nearest = &t;
    }
  }
  if (nearest == nullptr) return {};
  // Only what leads the arms astray counts without a closer look.
  const auto station = nearest->station;
  const bool end = station == Station::kLow || station == Station::kHigh || station == Station::kUp;
  if (end && (mirror_similarity(state, state) < kEven || !arms_fit(state.parts(), nearest->state.parts()))) return {};
  return {station, std::min(best, 1.0)};
}

std::optional<Movement> MovementDetector::complete(const Swing& swing) {
  if (swing.ways < kWays) return std::nullopt;
  return Movement{swing.name, swing.from, swing.to, (swing.sum + swing.best) / (swing.ways + 1)};
}

void MovementDetector::restart(Swing& swing) { swing = {swing.name, swing.low, swing.high}; }

std::optional<Movement> MovementDetector::visit(Swing& swing, double time_s, const AtStation& where) {
  std::optional<Movement> over;
  const auto station = where.station;
  if (swing.last != Station::kNowhere && time_s - swing.to > kLongestWay) {
    over = complete(swing);
    restart(swing);
  }
  if (station == Station::kNowhere || station == Station::kLevel) return over;
  if (station != swing.low && station != swing.high) {
    if (!over) over = complete(swing);
    restart(swing);
    return over;
  }
  if (swing.last == station) {
    swing.best = std::max(swing.best, where.likeness);
  } else {
    if (swing.last == Station::kNowhere) {
      swing.from = time_s;
    } else {
      ++swing.ways;
      swing.sum += swing.best;
    }
    swing.best = where.likeness;
    swing.last = station;
  }
  swing.to = time_s;
  return over;
}

std::optional<Movement> MovementDetector::add(double time_s, const AtStation& where) {
  std::optional<Movement> over;
  for (auto& swing : swings_) {
    if (auto done = visit(swing, time_s, where)) over = done;
  }
  return over;
}

std::optional<Movement> MovementDetector::finish() {
  std::optional<Movement> over;
  for (auto& swing : swings_) {
    if (!over) over = complete(swing);
    restart(swing);
  }
  return over;
}

}  // namespace choreo::recognition
