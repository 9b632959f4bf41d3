// SPDX-License-Identifier: Apache-2.0
// Where the person network comes from: MediaPipe's pose models, which script/run brings, or the user's folder.
#pragma once

#include <array>
#include <cstddef>
#include <string>

#include "vision/person/person_search.hpp"

namespace choreo::pipeline {

struct PersonModel {
  const char* file;
  const char* summary;
};
inline constexpr std::array<PersonModel, 3> kPersonModels = {
    {{"pose_landmark_full.tflite", "joints and silhouette of a person"},
     {"pose_landmark_lite.tflite", "the same, quicker and less sure"},
     {"pose_detection.tflite", "finds people in a whole picture"}}};
inline constexpr const char* kPersonModelsOrigin = "MediaPipe Pose, Apache-2.0, npm @mediapipe/pose 0.5.1675469404";
inline constexpr const char* kPersonModelsRemedy =
    "script/run brings them where npm and the network are; masks by segmentation = \"colour\" need none";

/// $XDG_CACHE_HOME/choreoscope/models, or .cache instead in the home folder.
[[nodiscard]] std::string usual_models_folder();

struct PersonModelOptions {
  std::string folder;  ///< Empty: the usual one.
  bool quick = false;  ///< The lite network instead of the full one.
  vision::PersonChoice choice = vision::PersonChoice::kLargest;
};

/// The files that are missing; empty: none.
[[nodiscard]] std::string missing_person_models(const PersonModelOptions& options);

/// What is the matter with a file that is there: one line, empty where it can be used.
/// @param model  its place in kPersonModels.
[[nodiscard]] std::string trouble_with_person_model(std::size_t model, const std::string& path);

/// Reads the two networks that are needed.
/// @throws Error (usage) where there is no folder, or a file is missing, cannot be read, or is not what it should be.
[[nodiscard]] vision::PersonSearch load_person_search(const PersonModelOptions& options);

}  // namespace choreo::pipeline
