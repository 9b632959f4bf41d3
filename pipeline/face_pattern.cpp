// SPDX-License-Identifier: Apache-2.0
#include "pipeline/face_pattern.hpp"

#include <algorithm>

#include <opencv2/imgproc.hpp>

#include "pipeline/working_size.hpp"

namespace choreo::pipeline {
namespace {

constexpr double kMost_px = 24;  // Across: enough to know a face again, and a third of a millisecond to find.
constexpr double kLeast_px = 6;

// As much of the square as is inside.
cv::Rect around(cv::Point2d centre, double half, cv::Size size) {
  const cv::Point from(cvFloor(centre.x - half), cvFloor(centre.y - half));
  const cv::Point to(cvCeil(centre.x + half), cvCeil(centre.y + half));
  return cv::Rect(from, to) & cv::Rect({0, 0}, size);
}

// The correlation of every part of the picture with the pattern, -1 to 1; of what is next to plain it is small.
cv::Mat correlation(const cv::Mat& grey, const cv::Mat& pattern) {
  constexpr double kPlain = 4;  // Grey levels, standard deviation; a division by less would make a face of noise.
  cv::Mat together, mean, squares;
  cv::matchTemplate(grey, pattern, together, cv::TM_CCOEFF);
  cv::boxFilter(grey, mean, CV_32F, pattern.size(), {0, 0});
  cv::sqrBoxFilter(grey, squares, CV_32F, pattern.size(), {0, 0});
  const cv::Rect inside({0, 0}, together.size());
  cv::Mat variance = squares(inside) - mean(inside).mul(mean(inside));
  cv::sqrt(cv::max(variance, kPlain * kPlain), variance);
  cv::Scalar middle, spread;
  cv::meanStdDev(pattern, middle, spread);
  return together / (variance * (std::max(spread[0], kPlain) * double(pattern.total())));
}

}  // namespace

FacePattern::FacePattern(const cv::Mat& bgr, cv::Size size, cv::Point2d centre, double width)
    : scale_(std::min(1.0, kMost_px / std::max(width, 1.0))), centre_(centre) {
  size_ = {std::max(1, cvRound(size.width * scale_)), std::max(1, cvRound(size.height * scale_))};
  where_ = around(scale_ * centre, scale_ * width / 2, size_);
  // One that is cut by the border is not followed along it.
  if (std::min(where_.width, where_.height) >= std::max(kLeast_px, scale_ * width / 2)) {
    grey_ = grey_part(bgr, size_, where_);
  }
}

std::optional<cv::Point2d> FacePattern::find(const cv::Mat& bgr, std::initializer_list<cv::Point2d> near) const {
  constexpr double kRoom = 1;  // Face widths.
  constexpr double kAlike = 0.6;
  if (grey_.empty()) return std::nullopt;
  cv::Rect where;
  for (const auto place : near) where |= around(scale_ * place, (kRoom + 0.5) * where_.width, size_);
  if (where.width < grey_.cols || where.height < grey_.rows) return std::nullopt;
  double best = 0;
  cv::Point at;
  cv::minMaxLoc(correlation(grey_part(bgr, size_, where), grey_), nullptr, &best, nullptr, &at);
  if (best < kAlike) return std::nullopt;
  return centre_ + cv::Point2d(where.tl() + at - where_.tl()) / scale_;
}

}  // namespace choreo::pipeline
