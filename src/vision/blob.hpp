// SPDX-License-Identifier: Apache-2.0
// A connected region and its moments to third order.
#pragma once

#include <opencv2/core/mat.hpp>

namespace choreo::vision {

/// Moments of a region in which every pixel weighs 1: area, centroid and central moments
/// mu_pq = sum (x - x_c)^p (y - y_c)^q. x to the right, y down, in pixels.
/// @source Performance Physics, 5.4.
struct Moments {
  double m00 = 0;        ///< Area, px.
  cv::Point2d centroid;  ///< px.
  double mu20 = 0, mu11 = 0, mu02 = 0;
  double mu30 = 0, mu21 = 0, mu12 = 0, mu03 = 0;
};

/// A region of one tone.
struct Blob {
  Moments moments;
  cv::Rect box;  ///< Smallest rectangle with all its pixels.
};

}  // namespace choreo::vision
