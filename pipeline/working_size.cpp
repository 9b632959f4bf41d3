// SPDX-License-Identifier: Apache-2.0
#include "pipeline/working_size.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace choreo::pipeline {

cv::Size working_size(cv::Size picture, int rows) {
  if (rows <= 0 || picture.height <= rows) return picture;
  const auto width = std::lround(double(picture.width) * rows / picture.height);
  return {std::max(1, static_cast<int>(width)), rows};
}

cv::Mat at_working_size(const cv::Mat& picture, cv::Size size) {
  if (picture.size() == size) return picture;
  cv::Mat out;
  cv::resize(picture, out, size, 0, 0, cv::INTER_AREA);
  return out;
}

}  // namespace choreo::pipeline
