// SPDX-License-Identifier: Apache-2.0
#include "pipeline/stages/particle_stage.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "core/error.hpp"
#include "vision/blobs.hpp"

namespace choreo::pipeline {
namespace {

vision::ToneSet starting_tones(const ParticleStageOptions& options) {
  auto tones = options.given;
  tones.outliers = options.tones.outliers;
  return tones;
}

vision::ArmOptions arm_options(const ParticleStageOptions& options) {
  auto arms = options.arms;
  arms.min_probability = options.tones.threshold;
  return arms;
}

std::vector<std::size_t> places(const vision::ToneSet& tones, const std::vector<std::string>& names) {
  std::vector<std::size_t> places;
  for (const auto& name : names) {
    const auto place = tones.find(name);
    if (place < tones.tones.size()) places.push_back(place);
  }
  return places;
}

// Where every frame is of that size, the first is refused.
void refuse_large(cv::Size size) {
  const int longest = std::max(size.width, size.height);
  if (longest <= vision::kLongestSide) return;
  throw usage_error(fmt::format("pictures of {} x {} are too large for arms to be looked for", size.width, size.height),
                    "working.rows",
                    fmt::format("no side may be longer than {}: working.rows is at most {} for these",
                                vision::kLongestSide, std::int64_t(size.height) * vision::kLongestSide / longest));
}

}  // namespace

ParticleStage::ParticleStage(ParticleStageOptions options)
    : options_(std::move(options)), mapper_(starting_tones(options_)), finder_(arm_options(options_)) {
  options_.tones.validate(options_.given.names());
  options_.bounds.validate();
  if (options_.tones.learn_skin || options_.tones.learn_clothes) learner_.emplace(options_.tones);
  arm_tones_ = places(mapper_.tones(), options_.tones.arms);
}

void ParticleStage::learn(const Observation& observation) {
  if (!learner_) return;
  bool taken = false;
  if (observation.face &&
      learner_->add(observation.picture, *observation.face, to_seconds(observation.time), observation.mask.mask)) {
    auto tones = starting_tones(options_);
    if (learner_->clothes()) tones.put(*learner_->clothes());
    if (options_.tones.learn_skin && learner_->skin()) tones.put(*learner_->skin());
    taken = mapper_.advance(1);  // What was begun last time, where frames are few.
    mapper_.prepare(std::move(tones));
  }
  // The first ones are wanted at once. Afterwards light changes slowly, and no frame is to wait for all of the tables.
  constexpr int kParts = 8;
  taken |= mapper_.advance(arm_tones_.empty() ? 1 : kParts);
  if (taken) arm_tones_ = places(mapper_.tones(), options_.tones.arms);
}

void ParticleStage::process(Observation& observation) {
  refuse_large(observation.picture.size());
  learn(observation);
  if (options_.tones.learn_skin && options_.tones.learn_s > 0) {
    observation.skin_learned = learner_->learned_s() / options_.tones.learn_s;
  }
  const auto& mask = observation.mask.mask;
  const auto time_s = to_seconds(observation.time);
  const auto posterior = mapper_.posterior(observation.picture, mask, arm_tones_);
  if (observation.mask.area > 0) {
    const auto least = std::ceil(255 * options_.tones.threshold);
    observation.tone_share = double(cv::countNonZero(posterior >= least)) / observation.mask.area;
  }
  observation.arms = finder_.find(posterior, mask, observation.face, time_s);
  observation.particles = body::particle_state_of(observation.arms, observation.face, options_.bounds);
}

}  // namespace choreo::pipeline
