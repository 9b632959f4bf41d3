// SPDX-License-Identifier: Apache-2.0
// How well the arms of every sign of semaphore cover what is seen of arms in one picture.
#pragma once

#include <array>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "recognition/semaphore_templates.hpp"

namespace choreo::recognition {

/// What an arm is, as of vision::ArmOptions; the defaults are bare forearms. Lengths in face widths.
struct SignCoverOptions {
  bool mirrored = false;  ///< As of SemaphoreOptions.
  double reach = 3.75;    ///< From the shoulder to the finger tip, or to the flag's end; 1 to 10.
  double typical_arm =
      1.25;  ///< Area of what is seen of an arm, be it forearm or flag, face widths squared; 0.1 to 10.
  double shoulder_aside = 1.25;  ///< From the face's middle; 0 to 5.
  double shoulder_below = 1.3;   ///< From the face's centre; 0 to 5.
};

/// Where an arm that explains the picture lies: from where it is bare to its finger tips, px of the picture.
struct CoveringArm {
  cv::Point2d from, to;
};

/// What the signs explain of one picture.
struct SignCoverage {
  /// Of each sign, by its place in body::semaphore_signs(): the cosine between what is seen and the sign's two arms,
  /// [0, 1], at their best angles, lengths and places.
  SignSimilarities overlap{};
  std::array<std::array<CoveringArm, 2>, kSemaphoreSigns> arms{};
  double seen = 0;  ///< All evidence within reach, in arms: 1 is the area of one (`typical_arm`).
};

/// A particle state needs two whole regions, one an arm. In a single picture arms are torn by sleeves and shadows,
/// touch each other or what stands behind; but two bars of an arm's width that leave the shoulders in a sign's
/// directions can still be laid over what there is. As of masks, the similarity is sum(e t) / sqrt(sum(e^2) sum(t)), e
/// being the evidence and t the two bars: what a sign leaves unexplained counts against it, as does what it expects in
/// vain.
///
/// A bar leaves either shoulder within 20 degrees of the sign's direction. It ends at `reach`, foreshortened or not,
/// begins a forearm's length (2.5 face widths; of a short reach two thirds) before that, give or take a sleeve, and is
/// as wide as makes that the area of an arm: 0.5 face widths of a bare forearm, 1.6 of the preset's flags. The body may
/// be larger or smaller than the face says and lean. The further off, the lower the overlap: by
/// exp(-(angle / 30 degrees)^2 / 2) for each arm, and alike for size and place.
/// @thread reentrant
class SignCover {
 public:
  explicit SignCover(const SignCoverOptions& options = {});

  /// @param evidence  CV_8UC1, how sure each pixel is of an arm, 255 being certain.
  /// @param face_centre, face_width  px of that picture; width > 0.
  /// @param one_hangs  of one arm nothing is to be seen because it never leaves its place, which is taken for hanging:
  ///   only signs with one arm down are looked at, by their other arm.
  /// @cost  about 30 ms for bare forearms, of pictures of any size; grows with the area of an arm.
  [[nodiscard]] SignCoverage cover(const cv::Mat& evidence, cv::Point2d face_centre, double face_width,
                                   bool one_hangs = false) const;

 private:
  SignCoverOptions options_;
};

}  // namespace choreo::recognition
