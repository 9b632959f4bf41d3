// SPDX-License-Identifier: Apache-2.0
#include "recognition/semaphore_reader.hpp"

#include <algorithm>
#include <cmath>

namespace choreo::recognition {
namespace {

constexpr double kBefore = 0.40;  // and how far back the states go that they are compared with
constexpr double kSlack = 1e-9;

struct Mean {
  std::array<Eigen::Vector2d, 2> arm = {Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  double time_s = 0;
  int count = 0;
};

double dot(const UnitPsi& a, const UnitPsi& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
  return sum;
}

}  // namespace

SemaphoreReader::SemaphoreReader(const SemaphoreOptions& options, const body::ParticleBounds& bounds)
    : templates_(options, bounds), stations_(options.mirrored, bounds) {}

SignMatch SemaphoreReader::match(const body::ParticleState& state) const {
  const auto& newest = recent_.back();
  UnitPsi sum{};
  for (const auto& s : recent_) {
    if (s.joined != newest.joined || s.time_s < newest.time_s - kRecentSigns_s) continue;
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += s.psi[k];
  }
  // Within so short a time states do not point apart.
  const double length = std::sqrt(std::max(dot(sum, sum), 1e-12));
  for (double& v : sum) v /= length;
  return templates_.match(sum, state);
}

// By places, not by Psi: near the bounds the smallest noise turns a lifted vector far.
bool SemaphoreReader::still() const {
  const auto& newest = recent_.back();
  std::array<Mean, 2> means;  // before, recent
  for (const auto& s : recent_) {
    if (s.joined != newest.joined) continue;
    auto& mean = means[s.time_s < newest.time_s - kRecentSigns_s ? 0 : 1];
    // One above the other, arms may change their order.
    const bool same = (s.arm[0] - s.arm[1]).dot(newest.arm[0] - newest.arm[1]) >= 0;
    for (std::size_t k = 0; k < 2; ++k) mean.arm[k] += s.arm[same ? k : 1 - k];
    mean.time_s += s.time_s;
    ++mean.count;
  }
  const auto& [before, recent] = means;
  if (before.count == 0) return false;
  const double seconds = recent.time_s / recent.count - before.time_s / before.count;
  for (std::size_t k = 0; k < 2; ++k) {
    const double way = (recent.arm[k] / recent.count - before.arm[k] / before.count).norm();
    if (way > templates_.options().still_widths_s * seconds) return false;
  }
  return true;
}

void SemaphoreReader::end_hold(SemaphoreStep& step) {
  step.ended.push_back(held_->told());
  held_.reset();
  left_.reset();
}

void SemaphoreReader::lapse(double time_s, bool seen, SemaphoreStep& step) {
  if (!last_state_) return;
  // From one state to the next no time was without one, however slowly frames come; only a gap in the frames was.
  const bool at_once = seen && last_state_ == last_;
  const double bridge = templates_.options().bridge_s;
  if (time_s - *last_state_ <= (at_once ? std::max(bridge, kSlowest_s) : bridge) + kSlack) return;
  if (held_) end_hold(step);
  candidate_.reset();
  recent_.clear();
}

void SemaphoreReader::follow(double time_s, const SignMatch& match, SemaphoreStep& step) {
  const auto& options = templates_.options();
  if (held_) {
    const auto& z = match.similarity;
    const double best = *std::max_element(z.begin(), z.end());
    const double own = z[held_->sign()];
    if (own >= options.least_similarity - options.hysteresis && own >= best - options.margin) {
      held_->go_on(time_s, step.now);
      left_.reset();
      candidate_.reset();
      return;
    }
    if (!left_) left_ = time_s;
    if (time_s - *left_ >= kLeaveSign_s - kSlack) end_hold(step);
  }
  const bool shown = step.now.sign && still();
  const std::size_t sign = shown ? body::place_of(*step.now.sign) : 0;
  if (!shown) {
    if (candidate_ && time_s - candidate_->to() >= kLeaveSign_s - kSlack) candidate_.reset();
    return;
  }
  if (!candidate_ || candidate_->sign() != sign) candidate_.emplace(sign, time_s);
  candidate_->go_on(time_s, step.now);
  if (time_s - candidate_->from() < options.hold_s - kSlack) return;
  if (held_) end_hold(step);
  held_ = candidate_;
  candidate_.reset();
}

SemaphoreStep SemaphoreReader::add(double time_s, const std::optional<body::ParticleState>& state) {
  SemaphoreStep step;
  if (last_ && time_s <= *last_) {
    if (held_) step.held = held_->told();
    return step;
  }
  lapse(time_s, state.has_value(), step);
  // Where frames come slowly, the one before is what a state is compared with.
  const double before = std::max(kBefore, std::min(last_ ? time_s - *last_ : 0.0, kSlowest_s));
  last_ = time_s;
  if (const auto made = movements_.add(time_s, state ? stations_.of(*state) : AtStation{})) step.ended.push_back(*made);
  if (state) {
    last_state_ = time_s;
    while (!recent_.empty() && recent_.front().time_s < time_s - before - kSlack) recent_.pop_front();
    const auto& parts = state->parts();
    recent_.push_back({time_s, unit_psi(*state), state->joined(), {parts.eta + parts.alpha, parts.eta - parts.alpha}});
    const auto matched = match(*state);
    step.now = templates_.read(matched);
    follow(time_s, matched, step);
  }
  if (held_) step.held = held_->told();
  return step;
}

std::vector<HeldSign> SemaphoreReader::finish() {
  SemaphoreStep step;
  if (held_) end_hold(step);
  if (const auto made = movements_.finish()) step.ended.push_back(*made);
  recent_.clear();
  candidate_.reset();
  last_.reset();
  last_state_.reset();
  return step.ended;
}

}  // namespace choreo::recognition
