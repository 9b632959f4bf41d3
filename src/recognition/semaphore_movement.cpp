// SPDX-License-Identifier: Apache-2.0
#include "recognition/semaphore_movement.hpp"

#include <algorithm>

namespace choreo::recognition {
namespace {

constexpr int kWays = 5;              // there, back, there, back, there: three times at either end
constexpr double kLongestWay = 1.25;  // seconds
constexpr double kNear = 0.85;        // Z from which the arms are at a station
constexpr double kEven = 0.80;        // Z* of a state with itself from which both arms do the same

}  // namespace

MovementDetector::MovementDetector(bool mirrored, const body::ParticleBounds& bounds)
    : swings_{{{kError, kLow, kHigh}, {kAttention, kHigh, kUp}}} {
  struct Place {
    Station station;
    int left, right;
    double spread;
  };
  constexpr std::array<Place, 7> kPlaces = {{{kRest, 0, 0, 0},
                                             {kLow, 7, 1, 0},
                                             {kLevel, 6, 2, 0},
                                             {kHigh, 5, 3, 0},
                                             {kUp, 4, 4, 0},
                                             {kUp, 4, 4, 12},
                                             {kUp, 4, 4, 24}}};
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

std::optional<Movement> MovementDetector::complete(const Swing& swing) {
  if (swing.ways < kWays) return std::nullopt;
  return Movement{swing.name, swing.from, swing.to, (swing.sum + swing.best) / (swing.ways + 1)};
}

void MovementDetector::restart(Swing& swing) { swing = {swing.name, swing.low, swing.high}; }

std::optional<Movement> MovementDetector::visit(Swing& swing, Station station, double time_s, double z) {
  std::optional<Movement> over;
  if (swing.last != kNowhere && time_s - swing.to > kLongestWay) {
    over = complete(swing);
    restart(swing);
  }
  if (station == kNowhere || station == kLevel) return over;
  if (station != swing.low && station != swing.high) {
    if (!over) over = complete(swing);
    restart(swing);
    return over;
  }
  if (swing.last == station) {
    swing.best = std::max(swing.best, z);
  } else {
    if (swing.last == kNowhere) {
      swing.from = time_s;
    } else {
      ++swing.ways;
      swing.sum += swing.best;
    }
    swing.best = z;
    swing.last = station;
  }
  swing.to = time_s;
  return over;
}

std::optional<Movement> MovementDetector::add(double time_s, const body::ParticleState& state) {
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
  // Only what leads the arms astray counts without a closer look.
  Station station = nearest != nullptr ? nearest->station : kNowhere;
  const bool end = station == kLow || station == kHigh || station == kUp;
  if (end && (mirror_similarity(state, state) < kEven || !arms_fit(state.parts(), nearest->state.parts()))) {
    station = kNowhere;
  }
  std::optional<Movement> over;
  for (auto& swing : swings_) {
    if (auto done = visit(swing, station, time_s, std::min(best, 1.0))) over = done;
  }
  return over;
}

std::optional<Movement> MovementDetector::pass(double time_s) {
  std::optional<Movement> over;
  for (auto& swing : swings_) {
    if (auto done = visit(swing, kNowhere, time_s, 0)) over = done;
  }
  return over;
}

std::optional<Movement> MovementDetector::going_on() const {
  for (const auto& swing : swings_) {
    if (auto movement = complete(swing)) return movement;
  }
  return std::nullopt;
}

std::optional<Movement> MovementDetector::finish() {
  const auto movement = going_on();
  for (auto& swing : swings_) restart(swing);
  return movement;
}

}  // namespace choreo::recognition
