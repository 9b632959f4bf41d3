// SPDX-License-Identifier: Apache-2.0
// What an ideal tone model would say of the figure: skin where its face, neck and arms are.
#pragma once

#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "body/figure.hpp"
#include "vision/face.hpp"

namespace choreo::test {

struct ArmPicture {
  cv::Mat tone;                ///< CV_8UC1, 255 where skin.
  cv::Mat body;                ///< CV_8UC1, 255 where body.
  std::array<cv::Mat, 2> arm;  ///< CV_8UC1, the bare part of each, whatever lies before it.
  vision::TrackedFace face;
};

struct ArmPictureOptions {
  cv::Size size{480, 420};
  double height_px = 300;      ///< Of the body.
  cv::Point2d feet{240, 400};  ///< On the floor, between them.
  double bare_from = 1;        ///< Along the arm: 0 the shoulder, 1 the elbow, 2 the wrist.
};

/// Draws a pose from the front.
inline ArmPicture arm_picture(const body::Pose& pose, const ArmPictureOptions& options = {}) {
  namespace v = body::vitruvian;
  const auto s = body::skeleton_of(pose);
  const double h = options.height_px;
  const auto at = [&](const Eigen::Vector3d& p) {
    return cv::Point2d(options.feet.x + h * p.x(), options.feet.y - h * p.y());
  };
  const auto capsule = [&](cv::Mat& picture, const Eigen::Vector3d& a, const Eigen::Vector3d& b, double width) {
    cv::line(picture, at(a) * 256, at(b) * 256, cv::Scalar(255), int(std::lround(width * h)), cv::LINE_8, 8);
  };
  ArmPicture p;
  p.tone = cv::Mat::zeros(options.size, CV_8UC1);
  p.body = cv::Mat::zeros(options.size, CV_8UC1);
  // Hairline to chin: a face width high, its centre below the head's.
  const Eigen::Vector3d face = s.crown - (1.0 / 40 + v::kFaceWidth / 2) * s.head_axes.col(1);
  p.face.centre = at(face);
  p.face.width = v::kFaceWidth * h;
  p.face.confidence = 1;
  cv::ellipse(p.tone, at(face), cv::Size(int(p.face.width / 2), int(p.face.width / 2 * 1.15)), 0, 0, 360,
              cv::Scalar(255), -1);
  capsule(p.tone, s.neck, face, 0.06);
  capsule(p.body, s.neck, s.skull, 0.1);
  capsule(p.body, s.neck, s.pelvis, 0.2);
  capsule(p.body, s.shoulder[0], s.shoulder[1], 0.08);
  for (std::size_t side = 0; side < 2; ++side) {
    auto& arm = p.arm[side];
    arm = cv::Mat::zeros(options.size, CV_8UC1);
    const std::array<Eigen::Vector3d, 4> joints{s.shoulder[side], s.elbow[side], s.wrist[side], s.fingertip[side]};
    for (int k = 0; k < 3; ++k) {
      const double from = std::clamp(options.bare_from - k, 0.0, 1.0);
      if (from == 1) continue;
      const auto& a = joints[std::size_t(k)];
      const auto& b = joints[std::size_t(k) + 1];
      // Caps stay within the limb.
      const double width = k == 0 ? 0.055 : v::kForearmWidth;
      const Eigen::Vector3d start = a + from * (b - a);
      const Eigen::Vector3d end = k == 2 ? Eigen::Vector3d(b - (b - a).normalized() * width / 2) : b;
      capsule(arm, start, end, width);
    }
    capsule(p.body, joints[0], joints[1], 0.07);
    capsule(p.body, s.hip[side], s.knee[side], 0.08);
    capsule(p.body, s.knee[side], s.ankle[side], 0.06);
    p.body |= arm;
    p.tone |= arm;
  }
  p.body |= p.tone;
  return p;
}

}  // namespace choreo::test
