// SPDX-License-Identifier: Apache-2.0
#include "pipeline/face_models.hpp"

#include <cstddef>
#include <filesystem>
#include <utility>

#include "pipeline/model_file.hpp"
#include "pipeline/yunet_faces.hpp"

namespace choreo::pipeline {

std::unique_ptr<vision::FaceDetector> load_face_detector(const FaceModelOptions& options) {
  options.haar.validate();
  if (!options.model.empty()) {
    require_model(options.model, "face.model is an ONNX file; without it OpenCV's cascades are used");
    return load_yunet(options.model);
  }
  const auto read = [&](const char* name) {
    const auto path = (std::filesystem::path(options.cascades) / name).string();
    constexpr std::size_t kMost = std::size_t{32} << 20U;  // The largest of OpenCV's has 2.7 MB.
    return vision::read_cascade(bytes_of_model(path, kMost, "a cascade",
                                               "the package opencv-data has it; another folder is chosen by "
                                               "face.cascades"),
                                path);
  };
  auto frontal = read("haarcascade_frontalface_alt.xml");
  auto profile = read("haarcascade_profileface.xml");
  return std::make_unique<vision::HaarFaceDetector>(std::move(frontal), std::move(profile), options.haar);
}

}  // namespace choreo::pipeline
