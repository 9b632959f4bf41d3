// SPDX-License-Identifier: Apache-2.0
// From a frame to the state of its silhouette: three thin adapters.
#pragma once

#include "body/silhouette_features.hpp"
#include "pipeline/stage.hpp"
#include "vision/body_masker.hpp"

namespace choreo::pipeline {

/// frame -> picture: the frame at the working resolution.
class PictureStage final : public Stage {
 public:
  explicit PictureStage(cv::Size size) : size_(size) {}
  [[nodiscard]] std::string name() const override { return "picture"; }
  void process(Observation& observation) override;

 private:
  cv::Size size_;
};

/// picture -> mask.
class MaskStage final : public Stage {
 public:
  explicit MaskStage(vision::BodyMasker masker) : masker_(std::move(masker)) {}
  [[nodiscard]] std::string name() const override { return "mask"; }
  void process(Observation& observation) override;

 private:
  vision::BodyMasker masker_;
};

/// mask -> state, quantity of motion, contraction.
class StateStage final : public Stage {
 public:
  explicit StateStage(double motion_window_s) : motion_(motion_window_s) {}
  [[nodiscard]] std::string name() const override { return "state"; }
  void process(Observation& observation) override;

 private:
  body::MotionMeter motion_;
};

}  // namespace choreo::pipeline
