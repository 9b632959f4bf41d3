// SPDX-License-Identifier: Apache-2.0
// Finds the background of a source before its frames are analysed.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "core/time.hpp"
#include "devices/source.hpp"
#include "vision/background_estimate.hpp"
#include "vision/depth_background.hpp"
#include "vision/segmenter.hpp"

namespace choreo::pipeline {

/// Where the background comes from: `auto`, `first:T` or the path of a picture of the empty room.
struct BackgroundSpec {
  enum class Kind { kAuto, kFirst, kPlate };
  Kind kind = Kind::kAuto;
  Nanoseconds first{0};  ///< T.
  std::string plate;     ///< Path.
};

/// @throws Error (usage) where `first:` is not followed by a duration above 0.
[[nodiscard]] BackgroundSpec parse_background(std::string_view text);

struct LearnedBackground {
  vision::BackgroundEstimate estimate;           ///< At the working size; nothing where depth alone decides.
  std::optional<vision::DepthBackground> depth;  ///< Likewise; nothing where colour alone decides.
  std::size_t pictures = 0;                      ///< That taught it; 0 for a plate.
  bool somebody = false;                         ///< Whether `people` saw somebody, more than by mistake.
  std::uint64_t frames_read = 0;
  /// The source to read from now on: it gives every frame from the first, those that taught the background included.
  std::unique_ptr<devices::Source> source;
};

using PeopleInPictures = std::function<std::vector<vision::PersonEvidence>(std::span<const cv::Mat>)>;

/// Learns the background of `source`.
/// @param plate  CV_8UC3 of the source's size, for Kind::kPlate.
/// @param reopen  opens the same source again; used where the source is repeatable. From one that is not, the frames
///   are kept and given again. From one that is not or not foreseeable, `auto` becomes the median of its first second.
/// @param progress  called with the share of the source read, 0 to 1, or less than 0 where the length is unknown.
/// @param segmentation  what is to be learned: colour, depth or both, from the same frames. A plate tells nothing of
///   depth: that is learned as by `auto`. Segmentation::kAuto learns what is behind people where it sees any.
/// @param margin  of the depth background.
/// @param people  where somebody is in each of some pictures, in order of time; needed for Segmentation::kPerson and
///   kAuto.
/// @return nothing where `stop` was requested.
/// @throws Error (usage) where there is no frame, the plate is of another size than the frames, or depth is asked for
///   and the frames have none.
[[nodiscard]] std::optional<LearnedBackground> learn_background(
    std::unique_ptr<devices::Source> source, const BackgroundSpec& spec, const cv::Mat& plate, int working_rows,
    const std::function<std::unique_ptr<devices::Source>()>& reopen, const std::function<void(double)>& progress,
    const std::stop_token& stop, vision::Segmentation segmentation = vision::Segmentation::kColour,
    const vision::DepthMargin& margin = {}, const PeopleInPictures& people = {});

}  // namespace choreo::pipeline
