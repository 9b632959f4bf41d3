// SPDX-License-Identifier: Apache-2.0
// A person's joints, drawn over the picture.
#pragma once

#include <opencv2/core/mat.hpp>

#include "vision/person/person.hpp"

namespace choreo::outputs {

/// A copy of the picture with trunk, arms, legs and head as lines between the joints that are seen (visibility 0.5).
/// @param picture  CV_8UC3.
/// @param look  in pixels of a picture of the same shape.
/// @param scale  from those pixels to the picture's.
[[nodiscard]] cv::Mat joints_drawn_over(const cv::Mat& picture, const vision::PersonLook& look, double scale);

}  // namespace choreo::outputs
