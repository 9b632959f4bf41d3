// SPDX-License-Identifier: Apache-2.0
// Random silhouettes that have a body's shape.
#pragma once

#include <random>

#include <opencv2/core/mat.hpp>

namespace choreo::bench {

/// A standing body in a random pose: head, trunk, arms and legs of two segments each, 85 to 95 % of the picture high.
/// @return CV_8UC1, 0 or 255, the centroid of the body within a pixel of the picture's centre where the body has room.
[[nodiscard]] cv::Mat random_body(std::mt19937& random, cv::Size picture);

}  // namespace choreo::bench
