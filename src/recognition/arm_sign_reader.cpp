// SPDX-License-Identifier: Apache-2.0
#include "recognition/arm_sign_reader.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>

namespace choreo::recognition {
namespace {

constexpr double kRecent = 0.20;      // Seconds of looks that are read as one.
constexpr double kSlowest = 1.0;      // Seconds between looks up to which they follow one another.
constexpr std::ptrdiff_t kLeast = 3;  // Looks that a hold takes.
constexpr double kShown = 0.5;        // Probability from which a sign is shown,
constexpr double kStays = 0.25;       // and down to which one that is held may fall.
constexpr double kSlack = 1e-3;       // Seconds; cameras count milliseconds.

bool both_seen(const std::optional<body::ArmPoses>& arms) { return arms && !arm_signs(*arms).arms_hidden; }

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
  const double begin = looks_.back().time_s - options_.hold_s + kSlack;
  // The last one that is early enough.
  const auto later = std::ranges::find_if(looks_, [&](const auto& look) { return look.time_s > begin; });
  if (later == looks_.begin()) return std::nullopt;
  return std::min(std::prev(later), std::prev(looks_.end(), kLeast));
}

// By thirds: where arms turn back, beginning and end are alike.
bool ArmSignReader::still(Looks::const_iterator from) const {
  const auto count = std::distance(from, looks_.end());
  const double most = options_.still_degrees_s * (looks_.back().time_s - from->time_s);
  std::array<body::ArmPoses, 3> thirds;
  for (std::ptrdiff_t k = 0; k < 3; ++k) {
    thirds[std::size_t(k)] = mean_of(std::next(from, k * count / 3), std::next(from, (k + 1) * count / 3));
  }
  return std::ranges::all_of(std::array{body::kLeft, body::kRight}, [&](auto side) {
    const auto turned = [&](std::size_t a, std::size_t b) {
      return std::abs(body::turn(thirds[a][side]->fore, thirds[b][side]->fore));
    };
    return std::max({turned(0, 1), turned(1, 2), turned(0, 2)}) <= most;
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
  if (time_s - *last_arms_ <= (at_once ? std::max(options_.bridge_s, kSlowest) : options_.bridge_s) + kSlack) return;
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
    if (time_s - *left_ < kLeaveSign_s - kSlack) return;
    end_hold(step);
    // The same sign again begins anew.
    looks_.erase(looks_.begin(), std::prev(looks_.end()));
  }
  const auto from = long_enough();
  if (!from || !still(*from)) return;
  const auto throughout = reading_of(arm_signs(mean_of(*from, looks_.end())));
  if (!throughout.sign || throughout.sign != now_.sign) return;
  held_.emplace(body::place_of(*throughout.sign), (*from)->time_s);
  held_->go_on(time_s, throughout);
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
  if (const auto made = movements_.add(time_s, seen ? station_of(*arms) : AtStation{})) {
    step.ended.push_back({made->name, made->from, made->to, made->confidence, {}});
  }
  now_ = {};
  if (seen) {
    last_arms_ = time_s;
    looks_.push_back({time_s, *arms});
    while (looks_.size() > std::size_t(kLeast) && looks_[1].time_s <= time_s - options_.hold_s - kRecent) {
      looks_.pop_front();
    }
    const auto recent =
        std::ranges::find_if(looks_, [&](const auto& look) { return look.time_s >= time_s - kRecent - kSlack; });
    const auto now = arm_signs(mean_of(recent, looks_.end()));
    now_ = reading_of(now);
    follow(time_s, now, step);
  }
  step.now = now_;
  if (held_) step.held = held_->told();
  return step;
}

SemaphoreStep ArmSignReader::last() const {
  SemaphoreStep step;
  step.now = now_;
  if (held_) step.held = held_->told();
  return step;
}

std::vector<HeldSign> ArmSignReader::finish() {
  SemaphoreStep step;
  if (held_) end_hold(step);
  if (const auto made = movements_.finish()) {
    step.ended.push_back({made->name, made->from, made->to, made->confidence, {}});
  }
  *this = ArmSignReader(options_);
  return step.ended;
}

}  // namespace choreo::recognition
