// SPDX-License-Identifier: Apache-2.0
// The last stage of a live run: keeps what the files at its end are made of, and shows the frame.
#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "cli/recording.hpp"
#include "cli/thumbnails.hpp"
#include "outputs/frames_csv.hpp"
#include "pipeline/stage.hpp"

namespace choreo::cli {

/// The rows of the frames that are in the history, and nothing older: memory does not grow with the run.
class LiveRecordStage final : public pipeline::Stage {
 public:
  /// @param particles  whether the rows' particle states are kept.
  /// @param show  given every frame that is done; may be empty.
  LiveRecordStage(ThumbnailKeeper thumbnails, bool particles, std::function<void(const pipeline::Observation&)> show)
      : thumbnails_(std::move(thumbnails)), keeps_particles_(particles), show_(std::move(show)) {}

  [[nodiscard]] std::string name() const override { return "show"; }
  void process(pipeline::Observation& observation) override;

  [[nodiscard]] std::vector<outputs::FrameRow> rows() const { return {rows_.begin(), rows_.end()}; }
  /// One a row, a gap where there is none; empty where they are not kept.
  [[nodiscard]] const std::deque<std::optional<body::ParticleState>>& particles() const { return particles_; }
  [[nodiscard]] const ThumbnailKeeper& thumbnails() const { return thumbnails_; }
  [[nodiscard]] std::size_t bodies() const;                              ///< Of the rows, those with a body.
  [[nodiscard]] std::size_t cut_bodies() const;                          ///< Of these, cut by the picture's border.
  [[nodiscard]] const MaskTally& masks_tally() const { return tally_; }  ///< Over the whole run.
  [[nodiscard]] std::vector<double> sudden_changes_s() const {
    return {sudden_changes_s_.begin(), sudden_changes_s_.end()};
  }

 private:
  ThumbnailKeeper thumbnails_;
  bool keeps_particles_;
  std::function<void(const pipeline::Observation&)> show_;
  std::deque<std::optional<body::ParticleState>> particles_;
  std::deque<outputs::FrameRow> rows_;
  std::deque<bool> cut_;                 // By row.
  std::deque<double> sudden_changes_s_;  // The latest.
  MaskTally tally_;
};

}  // namespace choreo::cli
