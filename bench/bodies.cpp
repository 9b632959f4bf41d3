// SPDX-License-Identifier: Apache-2.0
#include "bodies.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "body/mask_state.hpp"

namespace choreo::bench {
namespace {

// All points within `radius` of the segment from a to b.
void draw_limb(cv::Mat& mask, cv::Point2d a, cv::Point2d b, double radius) {
  const int x0 = std::max(0, int(std::floor(std::min(a.x, b.x) - radius)));
  const int x1 = std::min(mask.cols - 1, int(std::ceil(std::max(a.x, b.x) + radius)));
  const int y0 = std::max(0, int(std::floor(std::min(a.y, b.y) - radius)));
  const int y1 = std::min(mask.rows - 1, int(std::ceil(std::max(a.y, b.y) + radius)));
  const auto d = b - a;
  const double length2 = std::max(d.dot(d), 1e-9);
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const cv::Point2d p(x, y);
      const auto off = p - a - d * std::clamp((p - a).dot(d) / length2, 0.0, 1.0);
      if (off.dot(off) <= radius * radius) mask.at<uchar>(y, x) = 255;
    }
  }
}

}  // namespace

cv::Mat random_body(std::mt19937& random, cv::Size picture) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  // Angles from straight down, in radians, positive to the right.
  const auto along = [](double angle, double length) {
    return cv::Point2d(std::sin(angle) * length, std::cos(angle) * length);
  };
  const double height = between(0.85, 0.95) * picture.height;
  cv::Mat mask = cv::Mat::zeros(picture, CV_8UC1);
  const cv::Point2d hip(picture.width / 2.0, picture.height / 2.0 + 0.02 * height);
  const auto neck = hip - along(between(-0.15, 0.15), 0.3 * height);
  draw_limb(mask, hip, neck, 0.075 * height);
  draw_limb(mask, neck - cv::Point2d(0, 0.09 * height), neck - cv::Point2d(0, 0.1 * height), 0.06 * height);
  for (const double side : {-1.0, 1.0}) {
    const double shoulder = side * between(0.1, std::numbers::pi - 0.3);
    const auto elbow = neck + cv::Point2d(side * 0.07 * height, 0.02 * height) + along(shoulder, 0.17 * height);
    draw_limb(mask, neck, elbow, 0.027 * height);
    draw_limb(mask, elbow, elbow + along(shoulder + between(-0.8, 0.8), 0.2 * height), 0.022 * height);
    const double thigh = side * between(0.02, 0.5);
    const auto knee = hip + cv::Point2d(side * 0.04 * height, 0) + along(thigh, 0.24 * height);
    draw_limb(mask, hip, knee, 0.05 * height);
    draw_limb(mask, knee, knee + along(thigh + between(-0.3, 0.3), 0.23 * height), 0.033 * height);
  }
  const auto center = body::MaskState(mask).center();
  const cv::Point move(picture.width / 2 - center.x, picture.height / 2 - center.y);
  cv::Mat moved = cv::Mat::zeros(picture, CV_8UC1);
  const cv::Rect frame({0, 0}, picture);
  const auto to = (frame + move) & frame;
  mask(to - move).copyTo(moved(to));
  return moved;
}

}  // namespace choreo::bench
