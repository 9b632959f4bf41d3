// SPDX-License-Identifier: Apache-2.0
// Of several looks at one person, the arms that lie along the silhouette's limbs.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include "vision/person/person.hpp"
#include "vision/person/person_search.hpp"

namespace choreo::pipeline {

/// A look at a picture or at its mirror image.
struct ArmLook {
  vision::PersonLook look;  ///< In pixels of what was looked at.
  bool flipped = false;     ///< That was the mirror image.
};

/// A look and those beside it that tell where the arms are: at the mirror image, and, as who stretches the arms fills
/// the part of the picture that shows the person best, at a larger part.
/// @param count  1 to 4. Fewer come back where nobody is seen.
[[nodiscard]] std::vector<ArmLook> looks_for_arms(const cv::Mat& picture, const vision::PersonLook& look,
                                                  vision::PersonSearch& people, std::size_t count);

/// The first look with its shoulders, elbows and wrists where all looks say, of the network's points and of its
/// silhouettes: the network takes one arm for both now and then, and the silhouette is right even then.
///
/// Limbs are what the silhouettes show beside trunk, head and legs (ArmFit). The wrists are as visible as to the look
/// that is nearest, less where that is far (ArmFit::trust), and less where the arms explain less than half of the limbs
/// and of what of these arms lies outside: down to 0 at 0.3.
/// @param looks    at least one, at one person; the first not flipped. Those of who faces away, and those without a
///   silhouette, do not count: where that is the first it comes back as it is.
/// @param picture  its size.
[[nodiscard]] vision::PersonLook fitted_arms(std::span<const ArmLook> looks, cv::Size picture);

}  // namespace choreo::pipeline
