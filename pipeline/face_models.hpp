// SPDX-License-Identifier: Apache-2.0
// Where face detectors come from: files of OpenCV's, or of the user's.
#pragma once

#include <memory>
#include <string>

#include "vision/face_detector.hpp"
#include "vision/haar_faces.hpp"

namespace choreo::pipeline {

inline constexpr const char* kCascadeFolder = "/usr/share/opencv4/haarcascades";

struct FaceModelOptions {
  std::string cascades = kCascadeFolder;  ///< The folder of OpenCV's Haar cascades.
  std::string model;                      ///< An ONNX file for cv::FaceDetectorYN; empty: the cascades.
  vision::HaarOptions haar;
};

/// Reads haarcascade_frontalface_alt.xml and haarcascade_profileface.xml, or the model.
/// @throws Error (usage) where a file is missing, cannot be read, or is not what it should be.
[[nodiscard]] std::unique_ptr<vision::FaceDetector> load_face_detector(const FaceModelOptions& options);

}  // namespace choreo::pipeline
