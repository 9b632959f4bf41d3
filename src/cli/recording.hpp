// SPDX-License-Identifier: Apache-2.0
// The last stage of an analysis: keeps what the matrices, tables and plots are made of.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cli/thumbnails.hpp"
#include "outputs/frames_csv.hpp"
#include "outputs/npy.hpp"
#include "pipeline/stage.hpp"

namespace choreo::cli {

/// Everything that is kept of a run, a few kilobytes a frame.
class RecordStage final : public pipeline::Stage {
 public:
  /// @param masks  where every mask is written; may be null.
  /// @param seen  told the time of every frame that is done.
  RecordStage(ThumbnailKeeper thumbnails, outputs::NpyPictures* masks, std::function<void(Nanoseconds)> seen)
      : thumbnails_(std::move(thumbnails)), masks_(masks), seen_(std::move(seen)) {}

  [[nodiscard]] std::string name() const override { return "record"; }
  void process(pipeline::Observation& observation) override;

  [[nodiscard]] const std::vector<std::unique_ptr<const body::MaskState>>& states() const { return states_; }
  [[nodiscard]] std::vector<outputs::FrameRow>& rows() { return rows_; }
  [[nodiscard]] const ThumbnailKeeper& thumbnails() const { return thumbnails_; }
  [[nodiscard]] std::size_t bodies() const { return bodies_; }          ///< Frames with a body.
  [[nodiscard]] std::size_t cut_bodies() const { return cut_bodies_; }  ///< Of these, cut by the picture's border.
  [[nodiscard]] double body_pixels() const { return body_pixels_; }          ///< Over all frames.
  [[nodiscard]] double inferred_pixels() const { return inferred_pixels_; }  ///< Of these, decided by an inferred wall.
  [[nodiscard]] const std::vector<double>& sudden_changes_s() const { return sudden_changes_s_; }

 private:
  ThumbnailKeeper thumbnails_;
  outputs::NpyPictures* masks_;
  std::function<void(Nanoseconds)> seen_;
  std::vector<std::unique_ptr<const body::MaskState>> states_;
  std::vector<outputs::FrameRow> rows_;
  std::size_t bodies_ = 0;
  std::size_t cut_bodies_ = 0;
  double body_pixels_ = 0;
  double inferred_pixels_ = 0;
  std::vector<double> sudden_changes_s_;
};

}  // namespace choreo::cli
