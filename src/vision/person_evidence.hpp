// SPDX-License-Identifier: Apache-2.0
// What a look of the person network says of a picture's pixels.
#pragma once

#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "vision/camera_motion.hpp"

namespace choreo::vision {

/// Where a person is likely to be in a picture.
struct PersonEvidence {
  cv::Mat likely;       ///< CV_8UC1 of the picture's size: 0 to 255, by the network; empty: nobody is there.
  double doubt_px = 0;  ///< How far the person may have moved since, and how blurred the silhouette is.
  /// All that is no farther than `radius` from a line, in pixels of the picture.
  struct Limb {
    cv::Point2d from, to;
    double radius = 0;
  };
  std::vector<Limb> limbs =
      {};  ///< Where bones are, as thick as clothes are; may be the person's whatever `likely` says,
  std::vector<Limb> held = {};        ///< and so may what a hand holds.
  std::optional<double> seen_s = {};  ///< When; nothing: in this picture.
  cv::Mat others = {};        ///< CV_8UC1, as `likely`: somebody else, who is not to be body; empty: nobody else.
  cv::Mat about_others = {};  ///< CV_8UC1, 0 or 255: where these may be; empty with `others`.
};

/// Of the picture's height: hair, a held fan, what the silhouette rounds off.
inline constexpr double kPersonReach = 1 / 60.0;

/// Everything that may be the person's. CV_8UC1, 0 or 255.
[[nodiscard]] cv::Mat possible(const PersonEvidence& person, cv::Size size);

/// `limbs` as they are, so many pixels thicker, in `out`, CV_8UC1.
void draw(const std::vector<PersonEvidence::Limb>& limbs, double doubt_px, cv::Mat& out);

/// Where somebody else is or may be, and the person surely is not; 0 or 255. A Mat of all 0 where nobody else is.
[[nodiscard]] cv::Mat others_alone(const PersonEvidence& person, cv::Size size);

/// Both of them, as one.
[[nodiscard]] PersonEvidence together(PersonEvidence person, const PersonEvidence& other);

/// A picture's evidence as the reference would show it.
[[nodiscard]] PersonEvidence brought_back(const PersonEvidence& person, const CameraShift& shift);

}  // namespace choreo::vision
