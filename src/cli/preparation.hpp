// SPDX-License-Identifier: Apache-2.0
// Where every analysis begins: a source that is open, and the wall in it known.
#pragma once

#include <functional>
#include <memory>
#include <stop_token>

#include <opencv2/core/mat.hpp>

#include "cli/commands.hpp"
#include "cli/device_news.hpp"
#include "cli/source_options.hpp"
#include "cli/summary.hpp"
#include "devices/registry.hpp"
#include "pipeline/background.hpp"
#include "pipeline/core_limit.hpp"
#include "similarity/and_count.hpp"
#include "vision/segmenter.hpp"

namespace choreo::cli {

/// Opens the source that the options name, limits the threads for as long as it lives, and learns the background.
class Preparation {
 public:
  /// Opens the source and reads the plate where there is one.
  /// @param keep_raw  frames carry what the device gave, for a recording.
  /// @param sets  a folder may be a set of pictures.
  /// @throws Error; Interrupted
  Preparation(const SourceOptions& options, const config::Options& settings, Session& session, const Clock& clock,
              bool keep_raw = false, bool sets = false);

  /// Learns the background. `source` gives every frame from the first again afterwards.
  /// @return what makes masks from now on.
  /// @throws Error; Interrupted
  [[nodiscard]] vision::Segmenter learn();

  /// Before frames are read: whether the pictures have colours, by the first minute of a recording, or by the first 15
  /// frames of what cannot be read twice. What is too dark to tell counts as coloured. `source` still gives every
  /// frame.
  /// @throws Error
  [[nodiscard]] bool has_colour();

  /// Whether masks need somebody who looks for people (`PersonStage`).
  [[nodiscard]] bool looks_for_people() const;
  /// Whether the network may tell of arms: it is there, and `segmentation` is not `colour`, which does without.
  [[nodiscard]] bool can_look() const;

  /// Before `learn`: the settings that were given to the constructor have other values now.
  void settings_changed();

  DeviceNews news;  ///< Before the source, which tells it until its end.
  Summary summary;  ///< What is known of the source and its background so far.
  pipeline::FrameSelection selection;
  similarity::AndCountKernel kernel;
  std::unique_ptr<devices::Source> source;
  std::stop_token stop;  ///< The first Ctrl-C.

 private:
  [[nodiscard]] vision::Segmenter learn_still();
  [[nodiscard]] std::unique_ptr<devices::Source> open();
  void require_memory() const;

  const SourceOptions& options_;
  const config::Options& settings_;
  Session& session_;
  const Clock& clock_;
  bool keep_raw_;
  bool sets_;
  devices::Registry registry_;
  pipeline::CoreLimit cores_;
  pipeline::BackgroundSpec spec_;
  vision::Segmentation segmentation_;
  cv::Mat plate_;
};

}  // namespace choreo::cli
