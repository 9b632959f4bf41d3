// SPDX-License-Identifier: Apache-2.0
// Faces by OpenCV's Haar cascades.
#pragma once

#include <string>

#include <opencv2/objdetect.hpp>

#include "vision/face_detector.hpp"

namespace choreo::vision {

struct HaarOptions {
  int neighbours = 3;       ///< Windows that must agree, [1, 100].
  double scale_step = 1.1;  ///< Of the windows' sizes, [1.01, 2].

  void validate() const;  ///< @throws Error (usage) naming the option, its value and its range.
};

/// A cascade from its XML text, checked so that no number in it leads outside the text's own tables.
/// @param name  of the text, for messages.
/// @throws Error (usage) where the text is not XML, or no Haar cascade of OpenCV's present format.
[[nodiscard]] cv::CascadeClassifier read_cascade(const std::string& xml, const std::string& name);

/// Viola's and Jones' detector. The confidence is n / (n + 5) for n agreeing windows.
///
/// Without kBrightened it finds light and dark faces on walls of any brightness (haarcascade_frontalface_alt; the
/// `default` cascade misses dark faces before bright walls). No window is smaller than the cascade's own, 20
/// pixels, and few as small find a dark face; where small ones are looked for, the picture is enlarged, at most twice.
/// @source Viola, Jones, Rapid object detection using a boosted cascade of simple features, 2001; Lienhart, Maydt,
/// 2002.
class HaarFaceDetector final : public FaceDetector {
 public:
  /// @param frontal  of haarcascade_frontalface_alt.xml.
  /// @param profile  of haarcascade_profileface.xml; empty: kProfile finds nothing.
  HaarFaceDetector(cv::CascadeClassifier frontal, cv::CascadeClassifier profile, const HaarOptions& options);

  [[nodiscard]] std::vector<Face> detect(const cv::Mat& grey, const cv::Rect& where, double least_px, double most_px,
                                         FaceLook look) override;

 private:
  [[nodiscard]] std::vector<Face> run(cv::CascadeClassifier& cascade, const cv::Mat& grey, double least_px,
                                      double most_px, const FaceShape& shape) const;

  cv::CascadeClassifier frontal_;
  cv::CascadeClassifier profile_;
  HaarOptions options_;
};

}  // namespace choreo::vision
