// SPDX-License-Identifier: Apache-2.0
#include "recognition/arm_sign_reader.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numeric>

namespace choreo::recognition {
namespace {

constexpr std::ptrdiff_t kLeast = 3;  // Looks that a hold takes.
constexpr double kByChance = 1.5;     // Standard errors.
constexpr double kShown = 0.5;        // Probability from which a sign is shown,
constexpr double kBegins = 0.7;       // from which it is held,
constexpr double kStays = 0.25;       // and down to which one that is held may fall.
constexpr double kEarly = 1e-3;       // Seconds; cameras count milliseconds.
// No arm goes so far and comes back so near in so short a time: such a look was wrong.
constexpr double kStrays = 35, kComesBack = 20;  // Degrees,
constexpr double kStrayTime = 0.35;              // seconds.

bool both_seen(const std::optional<body::ArmPoses>& arms) { return arms && !arm_signs(*arms).arms_hidden; }

// Of the forearms, and half as much of the upper arms, which are seen less well. Arms that are both seen.
double apart(const body::ArmPoses& a, const body::ArmPoses& b) {
  double most = 0;
  for (const auto side : {body::kLeft, body::kRight}) {
    most = std::max({most, std::abs(body::turn(a[side]->fore, b[side]->fore)),
                     std::abs(body::turn(a[side]->upper, b[side]->upper)) / 2});
  }
  return most;
}

// Standard deviation of single looks, by second differences: whatever turns evenly has none.
double look_error(const std::vector<double>& degrees) {
  double square = 0;
  for (std::size_t k = 2; k < degrees.size(); ++k) {
    const double second = degrees[k - 2] - 2 * degrees[k - 1] + degrees[k];
    square += second * second;
  }
  return std::sqrt(square / 6 / std::max(1.0, double(degrees.size()) - 2));
}

SignReading reading_of(const ArmSigns& signs) {
  SignReading out;
  if (signs.arms_hidden) return out;
  if (signs.rest >= kShown) return {"REST", signs.rest, signs.best};
  if (signs.probability >= kShown) {
    const bool rest = signs.rest > signs.of[body::place_of(signs.next)];
    return {signs.best, signs.probability, rest ? "REST" : signs.next};
  }
  return {std::nullopt, 1 - std::max(signs.probability, signs.rest), signs.best};
}

}  // namespace

ArmSignReader::ArmSignReader(const SemaphoreOptions& options) : options_(options) { options_.validate(); }

body::ArmPoses ArmSignReader::mean_of(Looks::const_iterator from, Looks::const_iterator to) {
  std::vector<body::ArmPoses> arms;
  std::transform(from, to, std::back_inserter(arms), [](const auto& look) { return look.arms; });
  return body::mean_of(arms);
}

std::optional<ArmSignReader::Looks::const_iterator> ArmSignReader::long_enough() const {
  if (looks_.size() < std::size_t(kLeast)) return std::nullopt;
  const double begin = looks_.back().time_s - options_.hold_s + kEarly;
  // The last one that is early enough.
  const auto later = std::ranges::find_if(looks_, [&](const auto& look) { return look.time_s > begin; });
  if (later == looks_.begin()) return std::nullopt;
  return std::min(std::prev(later), std::prev(looks_.end(), kLeast));
}

// By thirds: where arms turn back, beginning and end are alike.
bool ArmSignReader::still(Looks::const_iterator from) const {
  const auto count = std::distance(from, looks_.end());
  const double most = options_.still_degrees_s * (looks_.back().time_s - from->time_s);
  const auto part_is_still = [&](body::Side side, double body::ArmPose::*part) {
    std::vector<double> turned;
    for (auto look = from; look != looks_.end(); ++look) {
      turned.push_back(body::turn((*from->arms[side]).*part, (*look->arms[side]).*part));
    }
    std::array<double, 3> third{};
    for (std::ptrdiff_t k = 0; k < 3; ++k) {
      const auto begin = turned.begin() + k * count / 3, end = turned.begin() + (k + 1) * count / 3;
      third[std::size_t(k)] = std::accumulate(begin, end, 0.0) / double(end - begin);
    }
    const auto [least, greatest] = std::ranges::minmax(third);
    return greatest - least <= most + kByChance * look_error(turned) / std::sqrt(double(count) / 3);
  };
  return std::ranges::all_of(std::array{body::kLeft, body::kRight}, [&](auto side) {
    return part_is_still(side, &body::ArmPose::upper) && part_is_still(side, &body::ArmPose::fore);
  });
}

void ArmSignReader::end_hold(SemaphoreStep& step) {
  step.ended.push_back(held_->told());
  held_.reset();
  left_.reset();
}

void ArmSignReader::lapse(double time_s, bool seen, SemaphoreStep& step) {
  if (!last_arms_) return;
  // From one look to the next no time was without arms, however slowly they come; only a gap between looks was.
  const bool at_once = seen && last_arms_ == last_;
  if (time_s - *last_arms_ <= (at_once ? std::max(options_.bridge_s, kSlowest_s) : options_.bridge_s) + kEarly) return;
  if (held_) end_hold(step);
  looks_.clear();
}

void ArmSignReader::follow(double time_s, const ArmSigns& now, SemaphoreStep& step) {
  if (held_) {
    if (now.of[held_->sign()] >= kStays) {
      held_->go_on(time_s, now_);
      left_.reset();
      return;
    }
    if (!left_) left_ = time_s;
    if (time_s - *left_ < kLeaveSign_s - kEarly) return;
    // What comes next began when the arms left; so the same sign again begins anew.
    std::erase_if(looks_, [&](const auto& look) { return look.time_s < *left_; });
    end_hold(step);
  }
  const auto from = long_enough();
  if (!from || !still(*from)) return;
  const auto throughout = reading_of(arm_signs(mean_of(*from, looks_.end())));
  if (!throughout.sign || throughout.sign != now_.sign || throughout.confidence < kBegins) return;
  held_.emplace(body::place_of(*throughout.sign), (*from)->time_s);
  held_->go_on(time_s, throughout);
}

// The last but one, where it is unlike the one after it and the two before it, which are alike.
void ArmSignReader::drop_stray() {
  if (looks_.size() < 4) return;
  const auto after = std::prev(looks_.end()), it = std::prev(after), before = std::prev(it),
             earlier = std::prev(before);
  if (after->time_s - before->time_s > kStrayTime) return;
  if (std::max(apart(earlier->arms, after->arms), apart(before->arms, after->arms)) > kComesBack) return;
  if (std::min(apart(before->arms, it->arms), apart(it->arms, after->arms)) > kStrays) looks_.erase(it);
}

SemaphoreStep ArmSignReader::add(double time_s, const std::optional<body::ArmPoses>& arms) {
  SemaphoreStep step;
  if (last_ && time_s <= *last_) {
    if (held_) step.held = held_->told();
    return step;
  }
  const bool seen = both_seen(arms);
  lapse(time_s, seen, step);
  last_ = time_s;
  if (const auto made = movements_.add(time_s, seen ? station_of(*arms) : AtStation{})) step.ended.push_back(*made);
  now_ = {};
  if (seen) {
    last_arms_ = time_s;
    looks_.push_back({time_s, *arms});
    drop_stray();
    while (looks_.size() > std::size_t(kLeast) && looks_[1].time_s <= time_s - options_.hold_s - kRecentSigns_s) {
      looks_.pop_front();
    }
    const auto recent =
        std::ranges::find_if(looks_, [&](const auto& look) { return look.time_s >= time_s - kRecentSigns_s - kEarly; });
    const auto now = arm_signs(mean_of(recent, looks_.end()));
    now_ = reading_of(now);
    follow(time_s, now, step);
  }
  return told(std::move(step));
}

SemaphoreStep ArmSignReader::told(SemaphoreStep step) const {
  step.now = now_;
  if (held_) step.held = held_->told();
  return step;
}

std::vector<HeldSign> ArmSignReader::finish() {
  SemaphoreStep step;
  if (held_) end_hold(step);
  if (const auto made = movements_.finish()) step.ended.push_back(*made);
  *this = ArmSignReader(options_);
  return step.ended;
}

}  // namespace choreo::recognition
