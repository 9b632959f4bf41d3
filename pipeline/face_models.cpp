// SPDX-License-Identifier: Apache-2.0
#include "pipeline/face_models.hpp"

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/error.hpp"
#include "pipeline/yunet_faces.hpp"

namespace choreo::pipeline {
namespace {

namespace fs = std::filesystem;

void require_file(const std::string& path, const std::string& hint) {
  std::error_code problem;
  const auto type = fs::status(path, problem).type();
  if (type == fs::file_type::not_found) throw usage_error(fmt::format("there is no \"{}\"", path), {}, hint);
  if (type != fs::file_type::regular) throw usage_error(fmt::format("\"{}\" is no file", path), {}, hint);
}

std::string text_of(const std::string& path, const std::string& hint) {
  constexpr std::size_t kMost = std::size_t{32} << 20U;  // The largest of OpenCV's has 2.7 MB.
  require_file(path, hint);
  std::ifstream file(path, std::ios::binary);
  std::string text(kMost + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (file.bad() || !file.is_open()) throw usage_error(fmt::format("\"{}\" cannot be read", path), {}, hint);
  if (text.size() > kMost) throw usage_error(fmt::format("\"{}\" is too large for a cascade", path), {}, hint);
  return text;
}

}  // namespace

std::unique_ptr<vision::FaceDetector> load_face_detector(const FaceModelOptions& options) {
  options.haar.validate();
  if (!options.model.empty()) {
    require_file(options.model, "face.model is an ONNX file; without it OpenCV's cascades are used");
    return load_yunet(options.model);
  }
  const auto read = [&](const char* name) {
    const auto path = (fs::path(options.cascades) / name).string();
    return vision::read_cascade(
        text_of(path, "the package opencv-data has it; another folder is chosen by face.cascades"), path);
  };
  auto frontal = read("haarcascade_frontalface_alt.xml");
  auto profile = read("haarcascade_profileface.xml");
  return std::make_unique<vision::HaarFaceDetector>(std::move(frontal), std::move(profile), options.haar);
}

}  // namespace choreo::pipeline
