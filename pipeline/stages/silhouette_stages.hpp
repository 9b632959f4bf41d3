// SPDX-License-Identifier: Apache-2.0
// From a frame to the state of its silhouette: three thin adapters.
#pragma once

#include "body/silhouette_features.hpp"
#include "pipeline/person_evidence.hpp"
#include "pipeline/stage.hpp"
#include "vision/segmenter.hpp"

namespace choreo::pipeline {

/// frame -> picture and, where it is looked at, depth: the frame at the working resolution.
class PictureStage final : public Stage {
 public:
  explicit PictureStage(cv::Size size, bool with_depth = false) : size_(size), with_depth_(with_depth) {}
  [[nodiscard]] std::string name() const override { return "picture"; }
  void process(Observation& observation) override;

 private:
  cv::Size size_;
  bool with_depth_;
};

/// picture, depth, person -> mask.
class MaskStage final : public Stage {
 public:
  explicit MaskStage(vision::Segmenter segmenter, OtherPeople others = OtherPeople::kLeftOut)
      : segmenter_(std::move(segmenter)), others_(others) {}
  [[nodiscard]] std::string name() const override { return "mask"; }
  void process(Observation& observation) override;

 private:
  vision::Segmenter segmenter_;
  OtherPeople others_;
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
