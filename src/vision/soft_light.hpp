// SPDX-License-Identifier: Apache-2.0
// Shadows and glows on the wall and floor, which differ from the background and are no body.
#pragma once

#include <opencv2/core/mat.hpp>

namespace choreo::vision {

/// `mask` without the changes of light that run into it from outside.
///
/// A soft shadow keeps the surface's colour: all channels are dimmed by one ratio. And it begins softly: the ratio
/// leaves 1 without a step. A body does neither, or has at least an outline that is a step. So the ratio of picture to
/// background is followed from the unchanged wall inwards as long as it is one for all channels and nowhere steep; what
/// is reached goes. What has an outline all around stays, whatever its colour, and so does a part of more than 0.3 % of
/// the picture whose border to the wall is, in the mean, as steep as an outline.
/// @param mask  CV_8UC1, 0 or 255.  @param picture, background  CV_8UC3 of its size, in the same light.
[[nodiscard]] cv::Mat without_soft_light(const cv::Mat& mask, const cv::Mat& picture, const cv::Mat& background);

}  // namespace choreo::vision
