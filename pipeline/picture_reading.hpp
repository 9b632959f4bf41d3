// SPDX-License-Identifier: Apache-2.0
// Reads the semaphore sign of a picture by itself, such as a photograph of a signaller.
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "body/particle_state.hpp"
#include "recognition/semaphore_options.hpp"
#include "recognition/semaphore_templates.hpp"
#include "vision/arm_finder.hpp"
#include "vision/face.hpp"
#include "vision/face_detector.hpp"
#include "vision/person/person_search.hpp"
#include "vision/tone_model.hpp"
#include "vision/tone_options.hpp"

namespace choreo::pipeline {

/// Pictures are looked at reduced, no side longer than this.
inline constexpr int kLongestPictureSide = 800;

/// The picture as it is looked at; the same where it is small enough.
[[nodiscard]] cv::Mat reduced_picture(const cv::Mat& picture);

/// Why a picture shows no sign.
enum class NoSign {
  kNobody,     ///< The person network sees nobody: nothing can be told.
  kHidden,     ///< An arm is hidden or beyond the picture, or both are one: nothing can be told.
  kNoFace,     ///< By tone: nobody's face is found: nothing can be told.
  kNoTone,     ///< By tone: none of arms is known: nothing can be told.
  kArmsHang,   ///< REST.
  kUnlikeAny,  ///< The arms point as in no sign.
};

/// What one picture shows, and what it was read from. Lengths in px of the picture.
struct PictureReading {
  std::optional<std::string_view> sign;  ///< Of body::semaphore_signs() but REST, which is no letter; nothing where
                                         ///< none is shown for certain.
  double confidence = 0;       ///< That the answer is right, be it a sign or none, 0 to 1; 0 where nothing can be told.
  std::string_view runner_up;  ///< The next sign but REST; where none is shown the nearest. Empty where no arm is seen.
  std::optional<NoSign> why = NoSign::kNoFace;  ///< Why there is no sign; nothing where there is one.
  std::optional<vision::Face> face;             ///< The signaller's; nothing where none is found.
  bool by_network = false;
  struct Forearm {
    cv::Point2d from, to;  ///< Elbow and wrist.
  };
  std::vector<Forearm> forearms;  ///< By the network.
  cv::Mat evidence;               ///< CV_8UC1, 255 where the person, or the arms' tone, is seen; may be empty.
};

/// By where the person network and its silhouettes show the forearms (`fitted_arms` of looks at the picture and at its
/// mirror image, `recognition::arm_signs`).
/// @param picture  CV_8UC3.  @param mirrored  as of SemaphoreOptions.
[[nodiscard]] PictureReading read_by_network(const cv::Mat& picture, vision::PersonSearch& people, bool mirrored);

struct ToneReaderOptions {
  double least_face = 0.04;  ///< Narrowest face, cheek to cheek, of the picture's height, [0.01, 0.5].
  double most_face = 0.8;    ///< Widest, (least_face, 1].
  recognition::SemaphoreOptions semaphore;
  vision::ToneOptions tones;
  vision::ArmOptions arms;  ///< `min_probability` is not looked at: `tones.threshold` is.
  body::ParticleBounds bounds;
  vision::ToneSet given;  ///< Tones that are known beforehand (gloves, flags); what is learned takes its name's place.

  void validate() const;  ///< @throws Error (usage) naming the option, its value and its range.
};

/// Without the network: by the arms' tone as in a video, skin's learned from the face in the picture itself. What has
/// that tone and lies where arms could be counts as arm.
/// @thread thread-bound
class ToneReader {
 public:
  /// @param faces  kept, not owned. @throws Error (usage) by options.validate().
  ToneReader(vision::FaceDetector& faces, ToneReaderOptions options);

  /// @param picture  CV_8UC3.
  [[nodiscard]] PictureReading read(const cv::Mat& picture) const;

 private:
  [[nodiscard]] std::optional<vision::Face> face_in(const cv::Mat& picture) const;
  [[nodiscard]] vision::ToneSet tones_of(const cv::Mat& picture, const vision::TrackedFace& face) const;

  vision::FaceDetector& faces_;
  ToneReaderOptions options_;
  recognition::SemaphoreTemplates signs_;
};

}  // namespace choreo::pipeline
