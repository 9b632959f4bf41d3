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

/// Whether `now` may be the surface `before` in another light, such as a shadow on it or a glow: one ratio, from
/// `darkest` to 1.5, serves all channels.
[[nodiscard]] bool same_surface(const cv::Vec3b& now, const cv::Vec3b& before, float darkest = 0.4F);

/// `mask` without what is beside the body: connected parts of which four fifths are the background in another light,
/// however sharp their outline, and parts of less than a third of the largest that lie mostly outside `reach`. The
/// largest stays.
/// @param reach  CV_8UC1, where a body is expected; empty: everywhere.
[[nodiscard]] cv::Mat without_parts_of_light(const cv::Mat& mask, const cv::Mat& picture, const cv::Mat& background,
                                             const cv::Mat& reach);

}  // namespace choreo::vision
