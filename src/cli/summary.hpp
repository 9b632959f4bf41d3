// SPDX-License-Identifier: Apache-2.0
// summary.json: what was analysed, with which settings, and what is to be known about the result.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "pipeline/background.hpp"
#include "pipeline/runner.hpp"

namespace choreo::cli {

/// What is particular to a live run.
struct LiveSummary {
  std::string pace;
  double history_s = 0;
  std::size_t capacity_rows = 0;
  std::size_t bytes_per_row = 0;
  std::size_t history_bytes = 0;
  std::size_t rows = 0;           ///< In the history at the end.
  pipeline::Latency row_full;     ///< What a row of Z and Z* took with the ring full,
  pipeline::Latency row_filling;  ///< and before.
};

struct Summary {
  devices::SourceInfo source;
  std::string span;
  std::uint64_t every = 1;
  cv::Size working_size;
  std::size_t frames = 0;
  std::size_t thinned_to_every = 1;  ///< Of the frames taken, the first of each so many is a row.
  std::size_t frames_without_body = 0;
  std::size_t frames_with_body_cut = 0;
  double first_time_s = 0;
  double last_time_s = 0;
  std::string body;                 ///< What counts as one where `segmentation` leaves it open.
  std::optional<double> threshold;  ///< Grey levels; absent where depth alone decides.
  vision::BackgroundEstimate background;
  std::optional<vision::DepthBackground> depth;  ///< Absent where colour alone decides.
  std::size_t background_pictures = 0;
  double inferred = 0;      ///< Share of the body's pixels, over all frames, that an inferred wall decided; 0 to 1.
  double camera_moved = 0;  ///< Share of the frames in which the room told nothing, since the camera moved; 0 to 1.
  std::vector<double> sudden_changes_s;
  bool particles = false;  ///< Whether states are particles, not silhouettes.
  cv::Size canvas;         ///< On which silhouettes were compared.
  std::vector<std::string> warnings;
  bool interrupted = false;
  std::vector<std::string> files;
  std::optional<LiveSummary> live;

  // Timings: the only part that differs from run to run.
  int threads = 0;
  std::string instruction_set;
  Nanoseconds learn_wall{0};
  pipeline::RunReport run;
  Nanoseconds pairs_wall{0};
  Nanoseconds plots_wall{0};

  /// Whether masks may have holes or ghosts: depth sees what stands before a wall that was never seen.
  [[nodiscard]] bool uncertain() const { return !depth && background.uncertain(); }
};

/// As indented JSON.
[[nodiscard]] std::string to_json(const Summary& summary, const config::Config& config);

/// The stages' times as lines of a table, for people.
[[nodiscard]] std::vector<std::string> timing_table(const Summary& summary);

/// Of a live run: frames, drops, latencies, and what the history costs.
[[nodiscard]] std::vector<std::string> live_table(const Summary& summary);

/// A line of latencies under `latency_heading()`.
[[nodiscard]] std::string latency_line(const std::string& name, const pipeline::Latency& latency);
[[nodiscard]] std::string latency_heading();

}  // namespace choreo::cli
