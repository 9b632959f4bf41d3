// SPDX-License-Identifier: Apache-2.0
// How one picture lies on another of the same scene, although the camera moved a little and somebody moves in front.
#pragma once

#include <opencv2/core/mat.hpp>

namespace choreo::vision {

/// What is left of a picture at forty pixels: enough to tell cheaply that two pictures show no common scene.
/// @thread reentrant
class SceneSketch {
 public:
  /// @param picture  CV_8UC3, of any size, not empty.
  /// @cost  that of reducing it to forty pixels.
  explicit SceneSketch(const cv::Mat& picture);

  /// The greatest correlation of the two under the shifts that `align_scene` searches, [-1, 1]; 0 where a picture has
  /// no contrast or their proportions differ.
  /// @cost  about 0.1 ms.
  [[nodiscard]] double likeness(const SceneSketch& other) const;

  /// Whether aligning is worth its time. Of pictures that `align_scene` aligns, the likeness was 0.65 and more at its
  /// largest turns and scales; of unrelated rooms it is under 0.2 for most.
  [[nodiscard]] bool may_share(const SceneSketch& other) const { return likeness(other) >= 0.4; }

 private:
  cv::Mat detail_;  // CV_32FC1
};

/// A similarity transform between two pictures, and whether they show one scene.
struct SceneAlignment {
  /// Takes a place in the reference to the same place of the scene in the picture: shift, rotation and one scale.
  /// Pixel centres at whole numbers. The identity where not `aligned`.
  cv::Matx23d picture_from_reference = {1, 0, 0, 0, 1, 0};
  /// Share of the reference's textured parts that look the same in the picture, the median over nine parts of the
  /// picture, so that a body that moves, or one that stands in the same place in two rooms, does not tell; [0, 1], of
  /// unrelated pictures near 0.
  double agreement = 0;
  /// Enough agrees that it can be no chance. Never of a picture without texture.
  bool aligned = false;
};

/// Finds shifts up to 6 % of the picture's width and height, scales within 4 % and rotations within 3 degrees, to a
/// fraction of a pixel, and is indifferent to exposure, white balance and slow shading.
///
/// Corners of the reference are followed to the picture, both high-passed and evened in contrast, and most of them
/// agree on the transform (CameraMotion), so that a body that moves has no word. Whether the result is a scene is
/// judged apart from that, by the correlation of small blocks.
/// @param reference, picture  CV_8UC3 of one size, at least 32 x 32 (smaller: not aligned).
/// @cost  about 0.03 s for 640 x 480 on one core.
/// @source Szeliski, Image Alignment and Stitching (2006), 4.
[[nodiscard]] SceneAlignment align_scene(const cv::Mat& reference, const cv::Mat& picture);

}  // namespace choreo::vision
