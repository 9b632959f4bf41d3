// SPDX-License-Identifier: Apache-2.0
// Which of the faces in pictures of one scene is the signaller's.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "vision/face.hpp"

namespace choreo::pipeline {

/// The faces of one picture and what moved in it, all on one canvas.
struct FacesOfView {
  std::vector<vision::Face> faces;
  cv::Mat difference;  ///< CV_8UC1, D from the wall.
  cv::Mat differs;     ///< CV_8UC1, 255 where that is more than noise.
};

struct SignallerFace {
  std::optional<vision::Face> face;
  bool seen = false;  ///< In this picture; else it is where it is in most others.
};

/// The signaller's face in every picture: the one that is found in the same place in most of them, with most of what
/// moves within an arm's reach, and that stirs itself. A poster does not stir, what is taken for a face by mistake is
/// found in few pictures. All get the median width, since a body does not grow from picture to picture.
/// @return one a view, all empty where no picture has a face.
[[nodiscard]] std::vector<SignallerFace> signaller_faces(std::span<const FacesOfView> views);

/// Of a picture by itself: the surest, large ones before small ones.
[[nodiscard]] SignallerFace best_face(std::span<const vision::Face> faces);

}  // namespace choreo::pipeline
