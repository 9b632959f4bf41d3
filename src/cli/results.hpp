// SPDX-License-Identifier: Apache-2.0
// From compared states to the files of a run: matrices, tables, plots, summary.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "cli/summary.hpp"
#include "config/config.hpp"
#include "outputs/frames_csv.hpp"
#include "outputs/npy.hpp"
#include "outputs/output_set.hpp"
#include "outputs/plot.hpp"
#include "similarity/comparer.hpp"

namespace choreo::cli {

/// What a run has gathered frame by frame.
struct Gathered {
  std::vector<outputs::FrameRow> rows;  ///< One a frame; Z*(t,t) is filled in by write_results.
  std::vector<outputs::Thumbnail> thumbnails;
  std::size_t bodies = 0;      ///< Frames with a body.
  std::size_t cut_bodies = 0;  ///< Of these, cut by the picture's border.
  std::vector<std::string> source_warnings;
  std::vector<std::string> signal_warnings;  ///< Of faces and arms.
};

/// Names the files of a run, and refuses at once where one of them cannot be written.
/// @param more  those that only some runs write.
/// @throws Error (usage)
void announce_files(Summary& summary, const outputs::OutputSet& files, const config::Options& settings,
                    const std::vector<std::string>& more);

/// How many rows the matrices of a source will have, by what it declares: at most `most`; 0 where it declares nothing.
[[nodiscard]] std::size_t expected_frames(const Summary& summary, const pipeline::FrameSelection& selection,
                                          std::size_t most);

/// Bytes that the files of so many frames need at least.
/// @param masks  size of the masks that are saved; empty: none are.
[[nodiscard]] std::uintmax_t space_for(std::size_t frames, cv::Size masks);

/// Compares all pairs and writes everything into `files`, which it commits.
/// @param states  as many as rows.
/// @param masks  the masks written beside, closed here; may be null.
/// @throws Interrupted at the second Ctrl-C, Error (failure); nothing is committed then.
void write_results(Summary& summary, const config::Config& config, const similarity::Comparer& states,
                   Gathered gathered, outputs::NpyPictures* masks, outputs::OutputSet& files, Session& session,
                   const Clock& clock);

/// Has `commit` remove what an earlier run wrote and this one does not: it would belong to another recording.
/// @param written  the names of this run's files.
void supersede_others(outputs::OutputSet& files, std::span<const std::string> written);

/// Fills in what the frames of a run were, and what is to be known of them; part of `write_results`.
/// @param gathered  with at least one row.
void sum_up(Summary& summary, const config::Options& settings, const Gathered& gathered);

/// Says on standard error what is to be known, on standard output how many frames had a body.
void tell_frames(const Summary& summary, Console& console);

/// Says on standard output what was written, on standard error what took how long and what is to be known.
void tell_results(const Summary& summary, const outputs::OutputSet& files, Console& console);

}  // namespace choreo::cli
