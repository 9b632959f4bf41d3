// SPDX-License-Identifier: Apache-2.0
// Reads the semaphore signs of a set of pictures, such as photographs of a signaller.
#pragma once

#include <array>
#include <cstdint>
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
#include "vision/arm_finder.hpp"
#include "vision/face.hpp"
#include "vision/face_detector.hpp"
#include "vision/person/person_search.hpp"
#include "vision/tone_model.hpp"
#include "vision/tone_options.hpp"

namespace choreo::pipeline {

struct PictureSetOptions {
  int longest_side = 800;      ///< px; larger pictures are reduced to it, 64 to 4096.
  double least_face = 0.04;    ///< Narrowest face, cheek to cheek, of the picture's height, [0.01, 0.5].
  double most_face = 0.8;      ///< Widest, (least_face, 1].
  double least_threshold = 7;  ///< Grey levels by which the body differs from the wall at least, [1, 255].
  recognition::SemaphoreOptions semaphore;
  vision::ToneOptions tones;
  /// What arms are like, be they bare forearms or flags: reach, typical_arm and the shoulders count.
  vision::ArmOptions arms;
  vision::ToneSet given;  ///< Tones that are known beforehand (gloves, flags); what is learned takes its name's place.

  void validate() const;  ///< @throws Error (usage) naming the option, its value and its range.
};

/// A picture as it is looked at: no side longer than `longest_side`. The same picture where it is small enough.
[[nodiscard]] cv::Mat reduced_picture(const cv::Mat& picture, int longest_side);

/// Why a picture shows no sign.
enum class NoSign {
  kNobody,     ///< The person network sees nobody: nothing can be told.
  kHidden,     ///< It sees somebody of whom an arm is hidden or beyond the picture: nothing can be told.
  kNoFace,     ///< Nobody's face is known, not from the others of its scene either: nothing can be told.
  kNoTone,     ///< No tone of arms is known: nothing can be told.
  kNoArms,     ///< Hardly anything is seen of arms where they could be.
  kArmsHang,   ///< REST.
  kUnlikeAny,  ///< What is seen of arms is covered by no sign well enough, or the forearms point as in none.
};

/// What one picture shows.
struct PictureAnswer {
  /// Of body::semaphore_signs() without REST, which is no letter; nothing where none is shown for certain.
  std::optional<std::string_view> sign;
  double confidence = 0;       ///< That the answer is right, be it a sign or none, 0 to 1.
  std::string_view runner_up;  ///< The next sign but REST; where none is shown the nearest. Empty where no arm is seen.
  std::optional<NoSign> why;   ///< Why there is no sign; nothing where there is one.
};

/// The sign that covers most, where it covers enough (0.45) of what is enough of an arm (0.25).
///
/// The confidence weighs every sign by exp(overlap / 0.03), and "no sign" as a sign at 0.45 and REST together; that
/// there is enough to be seen, by the logistic function of what is seen about 0.25, with the scale 0.05.
[[nodiscard]] PictureAnswer answer_of(const recognition::SignCoverage& coverage);

/// What one picture shows, and what it was read from. Lengths in px of the picture as it was given.
struct PictureReading {
  std::optional<std::string_view> sign;  ///< As of PictureAnswer, as are the next three.
  double confidence = 0;                 ///< 0 where no face is found or no tone is known: nothing is told then.
  std::string_view runner_up;
  std::optional<NoSign> why = NoSign::kNoFace;
  std::optional<vision::Face> face;  ///< The signaller's; nothing where none is found.
  bool face_seen = false;            ///< In this picture itself; else it is taken from the others.
  bool by_network = false;           ///< It was read by the person network, by itself.
  int faces = 0;                     ///< That were found, posters and false hits among them.
  bool shared = false;               ///< It shares its scene with others, and the wall is known from them.
  double overlap = 0;  ///< Between what is seen of arms and the arms of the nearest sign, REST or any, 0 to 1.
  std::array<recognition::CoveringArm, 2> arms{};  ///< Of the nearest sign, where `overlap` > 0.
  cv::Mat evidence;                                ///< CV_8UC1 of the picture's reduced size, 255 where an arm is seen.
};

/// Reads every picture of a set. Pictures that share a scene tell of the wall (`vision::SharedWall`), of whose face it
/// is (the one that is where things move, in most pictures) and of the skin's colour together; others are read by
/// themselves, by skin and face alone.
/// @param pictures  CV_8UC3, of any sizes. Their order says nothing and bears on little: in it tones are learned and
///   faces searched for thoroughly, and of many pictures evenly spread ones make the wall.
/// @param progress  told what is done, 0 to 1; may be empty.
/// @return a reading each; nothing where `stop` was requested.
[[nodiscard]] std::optional<std::vector<PictureReading>> read_pictures(std::span<const cv::Mat> pictures,
                                                                       vision::FaceDetector& detector,
                                                                       const PictureSetOptions& options,
                                                                       const std::function<void(double)>& progress = {},
                                                                       std::stop_token stop = {});

/// Reads one picture by itself, by where the person network sees the forearms (`recognition::arm_signs`): the mean of a
/// look at the picture and one at its mirror image. `evidence` is the person's silhouette, and `arms` go from the elbow
/// to the wrist.
/// @param picture  CV_8UC3.  @param mirrored  as of SemaphoreOptions.
[[nodiscard]] PictureReading read_by_network(const cv::Mat& picture, vision::PersonSearch& people, bool mirrored);

/// What `read_pictures` takes of memory at most, about, in bytes, with the reduced pictures themselves.
/// @param pixels  of all reduced pictures together.
[[nodiscard]] std::uint64_t bytes_to_read(std::uint64_t pixels, std::uint64_t pictures);

}  // namespace choreo::pipeline
