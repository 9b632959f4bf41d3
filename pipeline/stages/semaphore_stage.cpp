// SPDX-License-Identifier: Apache-2.0
#include "pipeline/stages/semaphore_stage.hpp"

#include <cstddef>
#include <utility>

namespace choreo::pipeline {
namespace {

constexpr std::size_t kShownText = 256;  // An evening's text is not copied for every frame.

}  // namespace

void SemaphoreStage::process(Observation& observation) {
  auto step = reader_.add(to_seconds(observation.time), observation.particles);
  take(step.ended);
  observation.signal = Signal{step.now, step.held, std::move(step.ended), speller_.text_with(step.held, kShownText)};
}

void SemaphoreStage::finish() { take(reader_.finish()); }

void SemaphoreStage::take(const std::vector<recognition::HeldSign>& ended) {
  for (const auto& sign : ended) speller_.add(sign);
  signs_.insert(signs_.end(), ended.begin(), ended.end());
}

}  // namespace choreo::pipeline
