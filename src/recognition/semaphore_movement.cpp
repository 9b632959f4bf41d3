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
  constexpr double kUneven = 13;  // Between T, which stands still, and arms that cross.
  constexpr double kStraight = 30;
  struct Range {
    Station station;
    double from, to, at;
  };
  constexpr std::array<Range, 5> kRanges = {{{Station::kRest, -90, 28, 0},
                                             {Station::kLow, 30, 60, 45},
                                             {Station::kLevel, 65, 115, 90},
                                             {Station::kHigh, 120, 150, 135},
                                             {Station::kUp, 152, 270, 180}}};
  const auto& left = arms[body::kLeft];
  const auto& right = arms[body::kRight];
  if (!left || !right) return {};
  // Outwards of either side.
  const double on_right = body::turn(90, right->fore) + 90, on_left = body::turn(90, -left->fore) + 90;
  const double mean = (on_right + on_left) / 2;
  if (std::abs(on_right - mean) > kUneven) return {};
  const auto straight = [](const auto& arm) { return std::abs(body::turn(arm.upper, arm.fore)) <= kStraight; };
  const auto range = std::ranges::find_if(kRanges, [&](const auto& r) { return mean >= r.from && mean <= r.to; });
  if (range == kRanges.end()) return {};
  const bool passed = range->station == Station::kRest || range->station == Station::kLevel;
  if (!passed && (!straight(*left) || !straight(*right))) return {};
  const double off = std::max(std::abs(on_right - range->at), std::abs(on_left - range->at));
  return {range->station, std::max(0.0, std::cos(off * std::numbers::pi / 180))};
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

std::optional<HeldSign> MovementDetector::complete(const Swing& swing) {
  if (swing.ways < kWays) return std::nullopt;
  return HeldSign{swing.name, swing.from, swing.to, (swing.sum + swing.best) / (swing.ways + 1), {}};
}

void MovementDetector::restart(Swing& swing) { swing = {swing.name, swing.low, swing.high}; }

std::optional<HeldSign> MovementDetector::visit(Swing& swing, double time_s, const AtStation& where) {
  std::optional<HeldSign> over;
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

std::optional<HeldSign> MovementDetector::add(double time_s, const AtStation& where) {
  std::optional<HeldSign> over;
  for (auto& swing : swings_) {
    if (auto done = visit(swing, time_s, where)) over = done;
  }
  return over;
}

std::optional<HeldSign> MovementDetector::finish() {
  std::optional<HeldSign> over;
  for (auto& swing : swings_) {
    if (!over) over = complete(swing);
    restart(swing);
  }
  return over;
}

}  // namespace choreo::recognition
