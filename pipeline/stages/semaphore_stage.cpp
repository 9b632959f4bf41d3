// SPDX-License-Identifier: Apache-2.0
#include "pipeline/stages/semaphore_stage.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "pipeline/seen_arms.hpp"

namespace choreo::pipeline {
namespace {

constexpr std::size_t kShownText = 256;  // An evening's text is not copied for every frame.
constexpr std::size_t kKeptText = 4096;  // Longer than what is shown and the longest word that ERROR takes away.

}  // namespace

SemaphoreStage::SemaphoreStage(const recognition::SemaphoreOptions& options, const body::ParticleBounds& bounds,
                               ReadsSigns reads, std::optional<Nanoseconds> history)
    : history_(history),
      mirrored_(options.mirrored),
      reader_(recognition::ArmSignReader(options)),
      shown_(options),
      forgotten_(options) {
  if (reads == ReadsSigns::kOfParticles) reader_.emplace<recognition::SemaphoreReader>(options, bounds);
}

recognition::SemaphoreStep SemaphoreStage::read(const Observation& o) {
  if (auto* of_particles = std::get_if<recognition::SemaphoreReader>(&reader_)) {
    return of_particles->add(to_seconds(o.time), o.particles);
  }
  auto& of_looks = std::get<recognition::ArmSignReader>(reader_);
  if (!o.looked) return of_looks.last();
  if (!o.person) return of_looks.add(to_seconds(*o.looked), std::nullopt);
  if (!o.person->arms) return of_looks.last();
  return of_looks.add(to_seconds(*o.looked), arm_poses(*o.person->arms, o.picture.size(), mirrored_));
}

void SemaphoreStage::process(Observation& observation) {
  auto step = read(observation);
  take(step.ended);
  observation.signal = Signal{step.now, step.held, std::move(step.ended), shown_.text_with(step.held, kShownText),
                              std::holds_alternative<recognition::ArmSignReader>(reader_)};
  if (history_) forget(to_seconds(observation.time - *history_));
}

void SemaphoreStage::finish() {
  take(std::visit([](auto& reader) { return reader.finish(); }, reader_));
}

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
