// SPDX-License-Identifier: Apache-2.0
// From picture, mask and face to the arms and the particle state.
#pragma once

#include <optional>
#include <vector>

#include "body/particle_state.hpp"
#include "pipeline/stage.hpp"
#include "vision/arm_finder.hpp"
#include "vision/tone_learner.hpp"
#include "vision/tone_mapper.hpp"

namespace choreo::pipeline {

struct ParticleStageOptions {
  vision::ToneOptions tones;
  vision::ToneSet given;    ///< Tones that are known from the start; what is learned takes the place of its name.
  vision::ArmOptions arms;  ///< `min_probability` is not looked at: `tones.threshold` is.
  body::ParticleBounds bounds;
};

/// picture, mask, face -> arms, particles.
///
/// Learns the skin from the face where that is asked for; until then there is no arm of that tone. Learns the clothes
/// where that is asked for, whether the skin is learned or given. Comes after MaskStage and FaceStage.
class ParticleStage final : public Stage {
 public:
  /// @throws Error (usage) for options out of range, and for an arm's tone that is neither given nor learned; by
  ///   process(), for a picture with a side longer than vision::kLongestSide.
  explicit ParticleStage(ParticleStageOptions options);

  [[nodiscard]] std::string name() const override { return "arms"; }
  void process(Observation& observation) override;

  /// Seconds of face that the skin was learned from; 0 where it is not learned.
  [[nodiscard]] double learned_s() const { return options_.tones.learn_skin ? learner_->learned_s() : 0.0; }

 private:
  void learn(const Observation& observation);

  ParticleStageOptions options_;
  std::optional<vision::ToneLearner> learner_;
  vision::ToneMapper mapper_;
  std::vector<std::size_t> arm_tones_;  // Places in the mapper's tones.
  vision::ArmFinder finder_;
};

}  // namespace choreo::pipeline
