// SPDX-License-Identifier: Apache-2.0
// The last stage of an analysis: keeps what the matrices, tables and plots are made of.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/kept_states.hpp"
#include "cli/summary.hpp"
#include "cli/thumbnails.hpp"
#include "outputs/frames_csv.hpp"
#include "outputs/npy.hpp"
#include "outputs/particles_csv.hpp"
#include "pipeline/stage.hpp"

namespace choreo::cli {

/// The row of frames.csv that belongs to an observation, but for Z*(t,t).
[[nodiscard]] outputs::FrameRow row_of(const pipeline::Observation& observation);

/// Likewise of particles.csv.
[[nodiscard]] outputs::ParticleRow particle_row_of(const pipeline::Observation& observation);

/// What decided masks, over all frames.
class MaskTally {
 public:
  void add(const vision::MaskResult& mask, double time_s) {
    if (mask.of_person && !of_person_from_s_) of_person_from_s_ = frames_ > 0 ? time_s : 0;
    body_ += mask.area;
    inferred_ += mask.inferred;
    ++frames_;
    if (mask.camera_moved) ++moved_;
  }
  /// Writes `inferred` and `camera_moved`, and into `body`, unless it is empty, since when it is a person.
  void tell(Summary& summary) const;

 private:
  std::optional<double> of_person_from_s_;  // 0: from the first frame on.
  double body_ = 0;                         // Pixels.
  double inferred_ = 0;
  double frames_ = 0, moved_ = 0;
};

/// Everything that is kept of a run, a few kilobytes a frame; of a long one every second frame, every fourth, ... so
/// that there are never more than so many.
class RecordStage final : public pipeline::Stage {
 public:
  /// @param states  where the state of every row goes.
  /// @param particle_rows  whether those are kept as well.
  /// @param most_rows  at least 2.
  /// @param masks  where every mask that is kept is written; may be null.
  /// @param seen  shown every frame that is done.
  RecordStage(KeptStates& states, bool particle_rows, std::size_t most_rows, ThumbnailKeeper thumbnails,
              outputs::NpyPictures* masks, std::function<void(const pipeline::Observation&)> seen)
      : states_(states),
        keeps_particle_rows_(particle_rows),
        most_rows_(most_rows),
        thumbnails_(std::move(thumbnails)),
        masks_(masks),
        seen_(std::move(seen)) {}

  [[nodiscard]] std::string name() const override { return "record"; }
  void process(pipeline::Observation& observation) override;

  [[nodiscard]] const std::vector<outputs::FrameRow>& rows() const { return rows_; }
  [[nodiscard]] const std::vector<outputs::ParticleRow>& particle_rows() const { return particle_rows_; }
  [[nodiscard]] const ThumbnailKeeper& thumbnails() const { return thumbnails_; }
  [[nodiscard]] std::size_t bodies() const;      ///< Rows with a body.
  [[nodiscard]] std::size_t cut_bodies() const;  ///< Of these, cut by the picture's border.
  [[nodiscard]] const std::vector<double>& sudden_changes_s() const { return sudden_changes_s_; }
  [[nodiscard]] const MaskTally& masks_tally() const { return tally_; }
  [[nodiscard]] std::size_t kept_every() const { return step_; }  ///< 1: every frame that came is a row.

 private:
  void thin_out();

  KeptStates& states_;
  bool keeps_particle_rows_;
  std::size_t most_rows_;
  std::size_t step_ = 1;
  std::size_t seen_frames_ = 0;
  ThumbnailKeeper thumbnails_;
  outputs::NpyPictures* masks_;
  std::function<void(const pipeline::Observation&)> seen_;
  std::vector<outputs::FrameRow> rows_;
  std::vector<outputs::ParticleRow> particle_rows_;
  std::vector<bool> cut_;  // By row.
  MaskTally tally_;
  std::vector<double> sudden_changes_s_;
};

}  // namespace choreo::cli
