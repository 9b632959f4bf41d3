// SPDX-License-Identifier: Apache-2.0
// From a picture and its background to the pixels that differ.
#pragma once

#include <opencv2/core/mat.hpp>

namespace choreo::vision {

/// Luminance of the per-channel difference: D = 0.299 |dR| + 0.587 |dG| + 0.114 |dB|, rounded to whole grey levels.
///
/// The difference is taken before the luminance, so that red before green of equal brightness is seen.
/// @param picture, background  CV_8UC3, blue green red, of one size.
/// @return CV_8UC1.
/// @source Performance Physics, 4.2.
[[nodiscard]] cv::Mat difference_luminance(const cv::Mat& picture, const cv::Mat& background);

/// The median of a CV_8UC1 picture with the position inside the grey level, so that noise below one level still tells.
[[nodiscard]] double interpolated_median(const cv::Mat& grey);

/// All that is set, with a margin in pixels, within the picture; empty where nothing is. What is done with a mask need
/// not be done elsewhere.
[[nodiscard]] cv::Rect around(const cv::Mat& mask, int margin);

/// Annealing: `steps` grow steps, then `steps` shrink steps, in the 8-neighbourhood.
///
/// What lies outside the picture is neutral in both: it neither grows in nor eats away. Closes gaps up to 2 steps
/// wide; never removes a pixel that was set.
/// @param mask  CV_8UC1, 0 or 255.
/// @param steps  0 or more.
/// @source Performance Physics, 4.2.
[[nodiscard]] cv::Mat annealed(const cv::Mat& mask, int steps);

/// Takes back from the edge of a mask what the picture blends from body and wall: a mask pixel that touches the
/// outside stays only where it differs from the wall at least half as much as the body beside it.
///
/// A lens and a pixel's own area spread an edge over two pixels; a threshold far below the body's contrast then
/// counts nearly all of them as body. Half contrast is where the true edge lies.
/// @param mask  CV_8UC1, 0 or 255.  @param difference  CV_8UC1, same size, as of `difference_luminance`.
[[nodiscard]] cv::Mat edge_at_half_contrast(const cv::Mat& mask, const cv::Mat& difference);

/// Takes back the halo that sharpening and compression draw around a body, at most two pixels wide: edge pixels that
/// differ from the wall less than a quarter as much as the body within two pixels.
[[nodiscard]] cv::Mat without_halo(const cv::Mat& mask, const cv::Mat& difference);

/// `mask` without its connected components (8-neighbourhood) of fewer than `min_area` pixels; with `only_largest`,
/// without all but the largest (the first in reading order among equals).
[[nodiscard]] cv::Mat without_specks(const cv::Mat& mask, int min_area, bool only_largest);

/// `mask` grown by a disc (OpenCV's chamfer distance, 3 x 3) and shrunk by one that is two pixels smaller: gaps are
/// closed, and edges stand out a little.
/// @param mask  CV_8UC1, 0 or 255.  @param radius  pixels, 2 or more.
[[nodiscard]] cv::Mat closed_by_disc(const cv::Mat& mask, double radius);

/// `mask` with its holes of at most `max_area` pixels filled: parts of the outside (4-neighbourhood) that do not touch
/// the picture's border.
[[nodiscard]] cv::Mat without_small_holes(const cv::Mat& mask, int max_area);

/// The convex hull of all of a mask; all 0 where the mask is.
/// @param mask  CV_8UC1, body where not 0.  @return CV_8UC1, 0 or 255.
[[nodiscard]] cv::Mat hull_of(const cv::Mat& mask);

}  // namespace choreo::vision
