// SPDX-License-Identifier: Apache-2.0
// Reads the semaphore signs of a set of pictures, such as photographs of a signaller.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "recognition/semaphore_options.hpp"
#include "recognition/sign_cover.hpp"
#include "vision/face.hpp"
#include "vision/face_detector.hpp"
#include "vision/tone_model.hpp"
#include "vision/tone_options.hpp"

namespace choreo::pipeline {

struct PictureSetOptions {
  int longest_side = 800;      ///< px; larger pictures are reduced to it, 64 to 4096.
  double least_face = 0.03;    ///< Of the picture's longer side, (0, 0.5].
  double least_threshold = 7;  ///< Grey levels by which the body differs from the wall at least, [1, 255].
  recognition::SemaphoreOptions semaphore;
  vision::ToneOptions tones;
  vision::ToneSet given;  ///< Tones that are known beforehand (gloves, flags); what is learned takes its name's place.

  void validate() const;  ///< @throws Error (usage) naming the option, its value and its range.
};

/// A picture as it is looked at: no side longer than `longest_side`. The same picture where it is small enough.
[[nodiscard]] cv::Mat reduced_picture(const cv::Mat& picture, int longest_side);

/// What one picture shows, and what it was read from. Lengths in px of the picture as it was given.
struct PictureReading {
  std::optional<std::string_view> sign;  ///< Of body::semaphore_signs(); nothing where none is shown for certain.
  double confidence = 0;                 ///< That the answer is right, be it a sign or none, 0 to 1.
  std::string_view runner_up;            ///< The next sign; empty where no arm is seen.
  std::optional<vision::Face> face;      ///< The signaller's; nothing where none is found.
  bool face_seen = false;                ///< In this picture itself; else it is taken from the others.
  int faces = 0;                         ///< That were found, posters and false hits among them.
  bool shared = false;                   ///< It shares its scene with others, and the wall is known from them.
  double overlap = 0;                    ///< Between what is seen of arms and the arms of the nearest sign, 0 to 1.
  std::array<recognition::CoveringArm, 2> arms{};  ///< Of the nearest sign, where `overlap` > 0.
  cv::Mat evidence;                                ///< CV_8UC1 of the picture's reduced size, 255 where an arm is seen.
};

/// Reads every picture of a set. Pictures that share a scene tell of the wall (`vision::SharedWall`), of whose face it
/// is (the one that is where things move, in most pictures) and of the skin's colour together; others are read by
/// themselves, by skin and face alone.
/// @param pictures  CV_8UC3, of any sizes, in any order: the order makes no difference but for rounding.
/// @param progress  told what is done, 0 to 1; may be empty.
/// @return a reading each; nothing where `stop` was requested.
[[nodiscard]] std::optional<std::vector<PictureReading>> read_pictures(std::span<const cv::Mat> pictures,
                                                                       vision::FaceDetector& detector,
                                                                       const PictureSetOptions& options,
                                                                       const std::function<void(double)>& progress = {},
                                                                       std::stop_token stop = {});

}  // namespace choreo::pipeline
