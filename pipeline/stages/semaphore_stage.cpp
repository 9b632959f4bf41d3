// SPDX-License-Identifier: Apache-2.0
#include "pipeline/stages/semaphore_stage.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace choreo::pipeline {
namespace {

constexpr std::size_t kShownText = 256;  // An evening's text is not copied for every frame.
constexpr std::size_t kKeptText = 4096;  // Longer than what is shown and the longest word that ERROR takes away.

}  // namespace

void SemaphoreStage::process(Observation& observation) {
  auto step = reader_.add(to_seconds(observation.time), observation.particles);
  take(step.ended);
  observation.signal = Signal{step.now, step.held, std::move(step.ended), shown_.text_with(step.held, kShownText)};
  if (history_) forget(to_seconds(observation.time - *history_));
}

void SemaphoreStage::finish() { take(reader_.finish()); }

void SemaphoreStage::take(const std::vector<recognition::HeldSign>& ended) {
  for (const auto& sign : ended) {
    shown_.add(sign);
    shown_.keep_end(kKeptText);
    ++ended_;
    letters_ += sign.sign != "REST" ? 1 : 0;
  }
  signs_.insert(signs_.end(), ended.begin(), ended.end());
}

void SemaphoreStage::forget(double before_s) {
  const auto kept = std::find_if(signs_.begin(), signs_.end(), [&](const auto& sign) { return sign.to >= before_s; });
  for (auto sign = signs_.begin(); sign != kept; ++sign) {
    forgotten_.add(*sign);
    forgotten_.keep_end(0);
    if (sign->sign != "REST") since_ = before_s;
  }
  if (since_) since_ = before_s;
  signs_.erase(signs_.begin(), kept);
}

std::string SemaphoreStage::text() const {
  auto speller = forgotten_;
  for (const auto& sign : signs_) speller.add(sign);
  return speller.text();
}

}  // namespace choreo::pipeline
