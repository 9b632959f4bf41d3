// SPDX-License-Identifier: Apache-2.0
// Paints a room in body coordinates: x from the stage's middle to the right, y up from the floor, units of H.
#pragma once

#include <algorithm>

#include <opencv2/core.hpp>

#include "devices/synthetic/look.hpp"
#include "devices/synthetic/room.hpp"

namespace choreo::devices::synthetic {

[[nodiscard]] inline cv::Scalar shade(const cv::Vec3f& colour, double factor) {
  return {colour[0] * factor, colour[1] * factor, colour[2] * factor};
}

/// A picture `margin` pixels larger on each side than the stage's.
class Painter {
 public:
  Painter(const Stage& stage, int margin, const Look& look) : stage_(stage), margin_(margin), look_(look) {
    picture_.create(stage.size.height + 2 * margin, stage.size.width + 2 * margin, CV_32FC3);
    picture_.setTo(shade(look.wall, 1));
  }

  [[nodiscard]] const Stage& stage() const { return stage_; }
  [[nodiscard]] const Look& look() const { return look_; }
  [[nodiscard]] int margin() const { return margin_; }

  [[nodiscard]] int column(double x) const { return cvRound(stage_.centre_x + stage_.unit * x) + margin_; }
  [[nodiscard]] int row(double y) const { return cvRound(stage_.floor_y - stage_.unit * y) + margin_; }
  [[nodiscard]] int thin() const { return std::max(1, cvRound(stage_.unit * 0.004)); }

  // A filled rectangle in body coordinates, from left and top to right and bottom.
  void block(double left, double top, double right, double bottom, const cv::Scalar& colour) {
    const cv::Rect area(cv::Point(column(left), row(top)), cv::Point(column(right), row(bottom)));
    const cv::Rect inside = area & cv::Rect(0, 0, picture_.cols, picture_.rows);
    if (!inside.empty()) picture_(inside).setTo(colour);
  }

  [[nodiscard]] cv::Mat& picture() { return picture_; }

 private:
  const Stage& stage_;
  int margin_;
  const Look& look_;
  cv::Mat picture_;
};

}  // namespace choreo::devices::synthetic
