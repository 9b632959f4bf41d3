// SPDX-License-Identifier: Apache-2.0
// Rooms and bodies for tests of vision: drawn, with known truth and seeded noise.
#pragma once

#include <cmath>
#include <random>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace choreo::test {

inline const cv::Scalar kRed(40, 50, 190);  ///< Clothes that no wall here resembles.

/// A wall with a gradient and a smooth texture, colours well inside 0 to 255.
inline cv::Mat textured_wall(cv::Size size, double base = 120) {
  cv::Mat wall(size, CV_8UC3);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double texture = 12 * std::sin(x * 0.13) * std::cos(y * 0.11) + 25.0 * x / size.width;
      wall.at<cv::Vec3b>(y, x) = {cv::saturate_cast<uchar>(base + texture),
                                  cv::saturate_cast<uchar>(base + 8 + texture),
                                  cv::saturate_cast<uchar>(base + 20 + texture)};
    }
  }
  return wall;
}

/// `picture` with independent Gaussian noise of that standard deviation in every channel.
inline cv::Mat with_noise(const cv::Mat& picture, double sigma, std::uint64_t seed) {
  cv::Mat noise(picture.size(), CV_32FC3);
  cv::RNG random(seed * 7919 + 13);
  random.fill(noise, cv::RNG::NORMAL, 0.0, sigma);
  cv::Mat out;
  picture.convertTo(out, CV_32F);
  out += noise;
  out.convertTo(out, CV_8U);
  return out;
}

/// `picture` with all levels times `gain`, plus `offset`.
inline cv::Mat in_light(const cv::Mat& picture, double gain, double offset = 0) {
  cv::Mat out;
  picture.convertTo(out, CV_8U, gain, offset);
  return out;
}

/// The mask of a standing figure: head, trunk and legs about `center`, `height` pixels tall.
inline cv::Mat figure_mask(cv::Size size, cv::Point center, int height) {
  cv::Mat mask = cv::Mat::zeros(size, CV_8UC1);
  const int h = height;
  cv::circle(mask, center - cv::Point(0, h * 42 / 100), h * 8 / 100, 255, cv::FILLED);
  cv::rectangle(mask, cv::Rect(center.x - h / 8, center.y - h * 36 / 100, h / 4, h * 40 / 100), 255, cv::FILLED);
  cv::rectangle(mask, cv::Rect(center.x - h / 8, center.y, h / 11, h / 2), 255, cv::FILLED);
  cv::rectangle(mask, cv::Rect(center.x + h / 8 - h / 11, center.y, h / 11, h / 2), 255, cv::FILLED);
  return mask;
}

/// `wall` with a body of one colour where `mask` is set.
inline cv::Mat with_body(const cv::Mat& wall, const cv::Mat& mask, const cv::Scalar& colour) {
  cv::Mat out = wall.clone();
  out.setTo(colour, mask);
  return out;
}

inline cv::Mat disc_mask(cv::Size size, cv::Point center, int radius) {
  cv::Mat mask = cv::Mat::zeros(size, CV_8UC1);
  cv::circle(mask, center, radius, 255, cv::FILLED);
  return mask;
}

/// Intersection over union of two masks; 1 where both are empty.
inline double iou(const cv::Mat& a, const cv::Mat& b) {
  const int both = cv::countNonZero(a & b);
  const int either = cv::countNonZero(a | b);
  return either == 0 ? 1.0 : double(both) / either;
}

/// The largest difference of any channel between two pictures, within `where` if given.
inline double largest_difference(const cv::Mat& a, const cv::Mat& b, const cv::Mat& where = {}) {
  cv::Mat difference;
  cv::absdiff(a, b, difference);
  if (!where.empty()) difference.setTo(cv::Scalar::all(0), ~where);
  double largest = 0;
  cv::minMaxLoc(difference.reshape(1), nullptr, &largest);
  return largest;
}

/// The mean difference over all channels.
inline double mean_difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1) / double(a.total() * std::size_t(a.channels()));
}

}  // namespace choreo::test
