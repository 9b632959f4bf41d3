// SPDX-License-Identifier: Apache-2.0
// A face as it looked in one picture, to be found again in the next ones.
#pragma once

#include <initializer_list>
#include <optional>

#include <opencv2/core/mat.hpp>

namespace choreo::pipeline {

/// Finds a face again by the normalised correlation of grey levels, at most 24 pixels across.
class FacePattern {
 public:
  /// @param bgr   CV_8UC3: the picture that has the face.
  /// @param size  the picture whose pixels places and widths are in, here and in `find`; of the shape of `bgr`.
  /// @param width  of the face, cheek to cheek. One that is small or mostly outside of the picture is never found.
  FacePattern(const cv::Mat& bgr, cv::Size size, cv::Point2d centre, double width);

  /// @param bgr   CV_8UC3, of the size of the first one.
  /// @param near  where it may be: within a face's width of these and between them.
  /// @return the centre; nothing where nothing is like it.
  [[nodiscard]] std::optional<cv::Point2d> find(const cv::Mat& bgr, std::initializer_list<cv::Point2d> near) const;

 private:
  cv::Size size_;     // Of the reduced picture.
  double scale_ = 1;  // It is so many times as large.
  cv::Point2d centre_;
  cv::Rect where_;  // In the reduced picture.
  cv::Mat grey_;    // Empty: never found.
};

}  // namespace choreo::pipeline
