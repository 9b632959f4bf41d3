// SPDX-License-Identifier: Apache-2.0
// Masks for tests, drawn in text or at random.
#pragma once

#include <random>
#include <string_view>
#include <vector>

#include <opencv2/core.hpp>

namespace choreo::test {

/// A mask of the given rows: '#' is body, anything else is not. All rows are equally long.
inline cv::Mat mask_of(const std::vector<std::string_view>& rows) {
  cv::Mat mask = cv::Mat::zeros(static_cast<int>(rows.size()), static_cast<int>(rows.front().size()), CV_8UC1);
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) {
      if (rows[std::size_t(y)][std::size_t(x)] == '#') mask.at<uchar>(y, x) = 255;
    }
  }
  return mask;
}

/// A mask of that size with each pixel body with the given probability; at least one pixel is.
inline cv::Mat random_mask(std::mt19937& random, cv::Size size, double density) {
  cv::Mat mask = cv::Mat::zeros(size, CV_8UC1);
  std::bernoulli_distribution body(density);
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) mask.at<uchar>(y, x) = body(random) ? 255 : 0;
  }
  mask.at<uchar>(size.height / 2, size.width / 2) = 255;
  return mask;
}

/// Whether two pictures have the same size, type and bytes.
inline bool same_bytes(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) return false;
  if (a.empty()) return true;
  return cv::countNonZero(a.reshape(1) != b.reshape(1)) == 0;
}

}  // namespace choreo::test
