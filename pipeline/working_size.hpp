// SPDX-License-Identifier: Apache-2.0
// The resolution at which a picture is looked at.
#pragma once

#include <opencv2/core/mat.hpp>

namespace choreo::pipeline {

/// The size with at most `rows` rows (0: no limit) and the picture's own shape; never larger than the picture, and at
/// least one pixel either way.
[[nodiscard]] cv::Size working_size(cv::Size picture, int rows);

/// The picture at that size, each pixel the mean of what it covers. The same picture where nothing changes.
[[nodiscard]] cv::Mat at_working_size(const cv::Mat& picture, cv::Size size);

/// A part of the picture at that size, grey.
/// @param where  in pixels of that size, inside it.
[[nodiscard]] cv::Mat grey_part(const cv::Mat& bgr, cv::Size size, const cv::Rect& where);

/// Depth at that size: each pixel the middle one of the valid readings (not 0) that it covers, the nearer of two; 0
/// where fewer than half are valid. Never a mean, which would put things where nothing is. The same picture where
/// nothing changes, and an empty one of an empty one.
/// @param depth  CV_16UC1, of any size.
[[nodiscard]] cv::Mat depth_at_working_size(const cv::Mat& depth, cv::Size size);

}  // namespace choreo::pipeline
