// SPDX-License-Identifier: Apache-2.0
#include "devices/synthetic/depth_camera.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "devices/synthetic/chance.hpp"

namespace choreo::devices::synthetic {
namespace {

constexpr double kWall_mm = 3500, kBody_mm = 2500, kHeight_mm = 1750;
constexpr double kFocal_px = 580, kFocalWidth_px = 640, kBaseline_mm = 75;
constexpr double kStepsPerPixel = 8;  // of disparity
constexpr double kNoise_mm = 2;       // at 2 m
constexpr double kFootOfWall = 0.05;  // in units of H above the floor under the body, as the room is painted
constexpr float kNearest_mm = 500;
constexpr float kJump_mm = 100;             // between neighbours in a row: an edge
constexpr float kJumpBetweenRows_mm = 400;  // the floor climbs by less
constexpr std::size_t kNoiseTable = std::size_t{1} << 16;

// What the projector reaches: it stands to the right of the camera, so a body's shadow falls on its left.
void shade_row(const float* z, int width, std::vector<unsigned char>& lit) {
  const double fb = kFocal_px * width / kFocalWidth_px * kBaseline_mm;
  double least = std::numeric_limits<double>::max();
  for (int x = width - 1; x >= 0; --x) {
    // The projector's column. Along one surface it falls with x; where it does not, a nearer surface is in the way.
    const double column = x - fb / z[x];
    lit[static_cast<std::size_t>(x)] = column < least ? 1 : 0;
    least = std::min(least, column);
  }
}

unsigned short quantised(double z) {
  constexpr double kSteps = kFocal_px * kBaseline_mm * kStepsPerPixel;
  return static_cast<unsigned short>(std::lround(kSteps / std::round(kSteps / z)));
}

}  // namespace

DepthCamera::DepthCamera(const Stage& stage, const Look& look, std::uint64_t seed)
    : stage_(stage), build_(look.build), seed_(mixed(seed, 501)), noise_(kNoiseTable) {
  for (std::size_t i = 0; i < kNoiseTable; ++i) {
    noise_[i] = static_cast<float>(std::clamp(normal(mixed(seed_, 502, i)), -4.0, 4.0));
  }
}

cv::Mat1f DepthCamera::room(cv::Point2d shift) const {
  cv::Mat1f depth(stage_.size);
  const double foot = stage_.floor_y + shift.y - kFootOfWall * stage_.unit;
  const double slope = (1 / kBody_mm - 1 / kWall_mm) / (kFootOfWall * stage_.unit);
  for (int y = 0; y < depth.rows; ++y) {
    const double v = (y + 0.5 - shift.y) / depth.rows - 0.5;
    const double below = y + 0.5 - foot;
    for (int x = 0; x < depth.cols; ++x) {
      const double u = (x + 0.5 - shift.x) / depth.cols - 0.5;
      double z = kWall_mm + 240 * u - 90 * v;
      // A level floor's inverse depth is linear in the picture's rows.
      if (below > 0) z = std::min(z, 1 / (1 / kWall_mm + slope * below));
      depth(y, x) = std::max(kNearest_mm, static_cast<float>(z));
    }
  }
  return depth;
}

void DepthCamera::place(cv::Mat1f& depth, const cv::Mat& body, const body::Pose& pose, cv::Point2d shift) const {
  const float nowhere = -std::numeric_limits<float>::max();
  cv::Mat1f forward(depth.size(), nowhere);  // towards the viewer, units of H
  for (const auto& part : body::ellipsoids_of(pose, build_)) {
    const Eigen::Vector3d h = part.half;
    const Eigen::Matrix3d q = part.axes * h.cwiseProduct(h).cwiseInverse().asDiagonal() * part.axes.transpose();
    const double reach = h.maxCoeff() * stage_.unit;
    const cv::Point2d centre(stage_.centre_x + shift.x + stage_.unit * part.centre.x(),
                             stage_.floor_y + shift.y - stage_.unit * part.centre.y());
    const int top = std::max(0, static_cast<int>(std::floor(centre.y - reach)));
    const int bottom = std::min(depth.rows - 1, static_cast<int>(std::ceil(centre.y + reach)));
    const int left = std::max(0, static_cast<int>(std::floor(centre.x - reach)));
    const int right = std::min(depth.cols - 1, static_cast<int>(std::ceil(centre.x + reach)));
    for (int y = top; y <= bottom; ++y) {
      const double b = (centre.y - y - 0.5) / stage_.unit;
      for (int x = left; x <= right; ++x) {
        const double a = (x + 0.5 - centre.x) / stage_.unit;
        // q(a, b, c) = 1 solved for the c nearer to the viewer.
        const double linear = q(0, 2) * a + q(1, 2) * b;
        const double rest = q(0, 0) * a * a + 2 * q(0, 1) * a * b + q(1, 1) * b * b - 1;
        const double root = linear * linear - q(2, 2) * rest;
        if (root < 0) continue;
        const auto c = static_cast<float>(part.centre.z() + (std::sqrt(root) - linear) / q(2, 2));
        forward(y, x) = std::max(forward(y, x), c);
      }
    }
  }
  // Clothes, hair and shoes reach beyond the ellipsoids: they take the depth of what is nearest in the picture.
  const auto box = cv::boundingRect(body);
  const cv::Mat1f ahead = forward(box);
  const cv::Mat covered = (ahead > nowhere) & (body(box) != 0);
  if (cv::countNonZero(covered) == 0) {
    depth.setTo(kBody_mm, body);
    return;
  }
  cv::Mat distance;
  cv::Mat1i nearest;
  cv::distanceTransform(covered == 0, distance, nearest, cv::DIST_L2, 5, cv::DIST_LABEL_PIXEL);
  std::vector<float> by_label(nearest.total() + 1, 0);
  for (int y = 0; y < box.height; ++y) {
    for (int x = 0; x < box.width; ++x) {
      if (covered.at<unsigned char>(y, x) != 0) by_label[static_cast<std::size_t>(nearest(y, x))] = ahead(y, x);
    }
  }
  for (int y = 0; y < box.height; ++y) {
    const auto* here = body.ptr<unsigned char>(box.y + y) + box.x;
    auto* out = depth.ptr<float>(box.y + y) + box.x;
    for (int x = 0; x < box.width; ++x) {
      if (here[x] == 0) continue;
      const double z = kBody_mm - kHeight_mm * double(by_label[static_cast<std::size_t>(nearest(y, x))]);
      out[x] = std::max(kNearest_mm, static_cast<float>(z));
    }
  }
}

cv::Mat DepthCamera::film(int index, const cv::Mat& body, const body::Pose& pose, cv::Point2d shift) const {
  auto truth = room(shift);
  if (!body.empty()) place(truth, body, pose, shift);
  cv::Mat seen = cv::Mat::zeros(stage_.size, CV_16UC1);
  std::vector<unsigned char> lit(static_cast<std::size_t>(truth.cols));
  for (int y = 0; y < truth.rows; ++y) {
    const auto* z = truth.ptr<float>(y);
    const auto* above = truth.ptr<float>(std::max(0, y - 1));
    const auto* below = truth.ptr<float>(std::min(truth.rows - 1, y + 1));
    auto* out = seen.ptr<unsigned short>(y);
    shade_row(z, truth.cols, lit);
    for (int x = 0; x < truth.cols; ++x) {
      // One number a pixel: the lowest bits choose the noise, the highest whether the pixel drops out.
      const auto chance =
          mixed(seed_, static_cast<std::uint64_t>(index), static_cast<std::uint64_t>(y), static_cast<std::uint64_t>(x));
      const double lot = uniform(chance);
      const int left = std::max(0, x - 1);
      const int right = std::min(truth.cols - 1, x + 1);
      const bool edge = std::abs(z[left] - z[x]) > kJump_mm || std::abs(z[right] - z[x]) > kJump_mm ||
                        std::abs(above[x] - z[x]) > kJumpBetweenRows_mm ||
                        std::abs(below[x] - z[x]) > kJumpBetweenRows_mm;
      int from = x;
      if (edge && lot > 0.5) from = lot > 0.75 ? right : left;
      if (lit[static_cast<std::size_t>(from)] == 0 || lot < (edge ? 0.25 : 0.005)) continue;
      const double depth = z[from];
      out[x] = quantised(depth + kNoise_mm * (depth / 2000) * (depth / 2000) *
                                     double(noise_[static_cast<std::size_t>(chance) % kNoiseTable]));
    }
  }
  return seen;
}

}  // namespace choreo::devices::synthetic
