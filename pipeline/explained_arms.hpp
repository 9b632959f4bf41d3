// SPDX-License-Identifier: Apache-2.0
// Of several looks at one person, the arms that explain the silhouette.
#pragma once

#include <span>

#include <opencv2/core/types.hpp>

#include "body/arm_poses.hpp"
#include "vision/person/person.hpp"

namespace choreo::pipeline {

/// A look at a picture or at its mirror image.
struct ArmLook {
  vision::PersonLook look;  ///< In pixels of what was looked at.
  bool flipped = false;     ///< That was the mirror image.
};

/// The part of the picture in which arms are seen best: who stretches them fills that which shows the person best.
[[nodiscard]] inline vision::PersonRegion larger_for_arms(vision::PersonRegion region) {
  region.side *= 1.25;
  return region;
}

/// Where the arms point by looks that do not agree: the network takes one arm for both now and then, and its silhouette
/// is right even then.
///
/// Each pair of a left and a right arm, of whichever looks, is judged by what the silhouettes show beside trunk, head
/// and legs: the share that lies along these arms, of all of it and of what of these arms lies outside. The result is
/// the mean of the best pairs that are alike. Where even these explain less than half, `seen` is lowered; less than
/// 0.3: to 0.
/// @param looks     at least one, at one person; the first not flipped.
/// @param picture   its size.  @param mirrored  the picture itself is a mirror image (SemaphoreOptions).
[[nodiscard]] body::ArmPoses explained_arms(std::span<const ArmLook> looks, cv::Size picture, bool mirrored = false);

}  // namespace choreo::pipeline
