// SPDX-License-Identifier: Apache-2.0
// Faces by a network of the user's own: OpenCV's FaceDetectorYN.
#pragma once

#include <memory>
#include <string>

#include "vision/face_detector.hpp"

namespace choreo::pipeline {

/// The detector "YuNet" as OpenCV 4.6 knows it (outputs loc, conf and iou). FaceLook::kAny and kFront are the network's
/// own search, which sees turned faces too; kProfile finds nothing more. OpenCV reads the file itself, so this is not
/// among the mathematics.
/// @param path  of an ONNX file; it is tried on an empty picture at once.
/// @throws Error (usage) where it is no such model.
[[nodiscard]] std::unique_ptr<vision::FaceDetector> load_yunet(const std::string& path);

}  // namespace choreo::pipeline
