// SPDX-License-Identifier: Apache-2.0
#include "vision/scene_alignment.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "vision/camera_motion.hpp"

namespace choreo::vision {
namespace {

constexpr int kSmallest = 32;         // Of a picture's side.
constexpr int kFineSide = 640;        // No level is finer: more pixels do not tell more about four numbers.
constexpr int kSketchSide = 40;       // Where a turn by 3 degrees moves the rim by a pixel.
constexpr double kShiftReach = 0.06;  // Of the side, for shifts.
constexpr double kNoise = 5;          // Grey levels: contrast below it is not made larger.
constexpr double kContrast = 20;      // Standard deviation of what has been evened.
constexpr double kTextured = 6;       // The same of a block that tells anything.
constexpr int kBlock = 32;            // Pixels of the finest level.
constexpr int kCells = 3;             // Of the picture, along each side.
constexpr int kLeastOfCell = 3;       // Textured blocks.
constexpr double kSame = 0.8;         // Correlation of a block with itself in another picture; of chance about 0.1.
constexpr double kLeastAgreement = 0.25;
constexpr int kLeastBlocks = 8;  // That agree.

struct Level {
  cv::Mat reference, picture;  // CV_32FC1, as of `evened`.
};

cv::Mat luminance(const cv::Mat& bgr, cv::Size size) {
  cv::Mat small;
  cv::resize(bgr, small, size, 0, 0, size.width < bgr.cols ? cv::INTER_AREA : cv::INTER_LINEAR);
  cv::Mat grey;
  cv::cvtColor(small, grey, cv::COLOR_BGR2GRAY);
  cv::Mat out;
  grey.convertTo(out, CV_32F);
  return out;
}

// Without what changes slowly over the picture (exposure, vignetting, the shading of a lamp that was moved), and with
// the same contrast everywhere, so that a bright shirt does not outvote a pale wall.
cv::Mat evened(const cv::Mat& grey, double sigma) {
  const auto blurred = [](const cv::Mat& in, double by) {
    cv::Mat out;
    cv::GaussianBlur(in, out, {}, by, by, cv::BORDER_REFLECT_101);
    return out;
  };
  const cv::Mat detail = blurred(grey, 0.8) - blurred(grey, sigma);
  cv::Mat contrast;
  cv::sqrt(blurred(detail.mul(detail), sigma), contrast);
  cv::Mat out;
  cv::divide(detail, contrast + kNoise, out, kContrast);
  return out;
}

cv::Mat warped(const cv::Mat& picture, const cv::Matx23d& picture_from_reference) {
  cv::Mat out;
  cv::warpAffine(picture, out, picture_from_reference, picture.size(), cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                 cv::BORDER_CONSTANT, cv::Scalar::all(0));
  return out;
}

// CV_8UC1, 255 where the picture covers the reference.
cv::Mat covered(cv::Size size, const cv::Matx23d& picture_from_reference) {
  cv::Mat inside = warped(cv::Mat(size, CV_8UC1, cv::Scalar(255)), picture_from_reference);
  return inside == 255;
}

cv::Mat in_bytes(const cv::Mat& evened) {
  cv::Mat out;
  evened.convertTo(out, CV_8U, 2, 128);
  return out;
}

// A camera that stands on a tripod and is touched, or is held.
bool plausible(const CameraShift& shift, cv::Size size) {
  const double scale = std::hypot(shift(0, 0), shift(1, 0));
  const double turn = std::atan2(shift(1, 0), shift(0, 0));
  const cv::Vec2d middle = shift * cv::Vec3d(0.5 * (size.width - 1), 0.5 * (size.height - 1), 1);
  return std::abs(scale - 1) < 0.06 && std::abs(turn) < 0.08 &&
         std::abs(middle[0] - 0.5 * (size.width - 1)) < 0.1 * size.width &&
         std::abs(middle[1] - 0.5 * (size.height - 1)) < 0.1 * size.height;
}

struct Agreement {
  int same = 0;      // Blocks.
  double share = 0;  // Of the textured blocks, in the median over the picture's cells.
};

// The cells keep somebody who stands in the same place in two rooms from being taken for a scene.
Agreement agreement_of(const Level& level, const cv::Matx23d& matrix) {
  const cv::Mat picture = warped(level.picture, matrix);
  const cv::Mat inside = covered(picture.size(), matrix);
  std::array<std::array<int, 2>, kCells * kCells> cells{};  // Textured blocks, and those of them that are the same.
  for (int y = 0; y + kBlock <= picture.rows; y += kBlock) {
    for (int x = 0; x + kBlock <= picture.cols; x += kBlock) {
      const cv::Rect block(x, y, kBlock, kBlock);
      if (cv::countNonZero(inside(block)) < kBlock * kBlock) continue;
      const auto r = level.reference(block);
      const auto p = picture(block);
      cv::Scalar r_mean, r_deviation, p_mean, p_deviation;
      cv::meanStdDev(r, r_mean, r_deviation);
      if (r_deviation[0] < kTextured) continue;
      auto& cell = cells[std::size_t(y * kCells / picture.rows * kCells + x * kCells / picture.cols)];
      ++cell[0];
      cv::meanStdDev(p, p_mean, p_deviation);
      if (p_deviation[0] < 0.25 * kTextured) continue;
      const double covariance = r.dot(p) / (kBlock * kBlock) - r_mean[0] * p_mean[0];
      if (covariance > kSame * r_deviation[0] * p_deviation[0]) ++cell[1];
    }
  }
  Agreement out;
  std::vector<double> shares;
  for (const auto& [textured, same] : cells) {
    out.same += same;
    if (textured >= kLeastOfCell) shares.push_back(double(same) / textured);
  }
  if (shares.empty()) return out;
  std::sort(shares.begin(), shares.end());
  out.share = 0.5 * (shares[(shares.size() - 1) / 2] + shares[shares.size() / 2]);
  return out;
}

}  // namespace

SceneSketch::SceneSketch(const cv::Mat& picture) {
  assert(picture.type() == CV_8UC3 && !picture.empty());
  const double shrink = double(kSketchSide) / std::max(picture.cols, picture.rows);
  const cv::Size size(std::max(1, cvRound(picture.cols * shrink)), std::max(1, cvRound(picture.rows * shrink)));
  detail_ = evened(luminance(picture, size), kSketchSide / 10.0);
}

double SceneSketch::likeness(const SceneSketch& other) const {
  if (detail_.size() != other.detail_.size()) return 0;
  const int reach_x = int(std::ceil(kShiftReach * detail_.cols));
  const int reach_y = int(std::ceil(kShiftReach * detail_.rows));
  double best = -1;
  for (int dy = -reach_y; dy <= reach_y; ++dy) {
    for (int dx = -reach_x; dx <= reach_x; ++dx) {
      const cv::Rect here(std::max(0, -dx), std::max(0, -dy), detail_.cols - std::abs(dx), detail_.rows - std::abs(dy));
      if (here.width <= 0 || here.height <= 0) continue;
      const cv::Mat a = detail_(here);
      const cv::Mat b = other.detail_(here + cv::Point(dx, dy));
      const double count = here.area();
      const double sum_a = cv::sum(a)[0];
      const double sum_b = cv::sum(b)[0];
      const double spread = (a.dot(a) - sum_a * sum_a / count) * (b.dot(b) - sum_b * sum_b / count);
      if (spread <= 1e-6 * count * count) return 0;
      best = std::max(best, (a.dot(b) - sum_a * sum_b / count) / std::sqrt(spread));
    }
  }
  return std::clamp(best, -1.0, 1.0);
}

SceneAlignment align_scene(const cv::Mat& reference, const cv::Mat& picture) {
  assert(reference.type() == CV_8UC3 && picture.type() == CV_8UC3 && reference.size() == picture.size());
  SceneAlignment out;
  const auto size = reference.size();
  const int longer = std::max(size.width, size.height);
  if (std::min(size.width, size.height) < kSmallest) return out;
  const double shrink = std::min(1.0, double(kFineSide) / longer);
  const cv::Size small(std::max(kSmallest, cvRound(size.width * shrink)),
                       std::max(kSmallest, cvRound(size.height * shrink)));
  const double sigma = std::max(small.width, small.height) / 20.0;
  const Level level{evened(luminance(reference, small), sigma), evened(luminance(picture, small), sigma)};
  const auto found = CameraMotion(in_bytes(level.reference)).of(in_bytes(level.picture), kNoShift, 0);
  if (!found || !plausible(*found, small)) return out;
  const auto blocks = agreement_of(level, *found);
  out.agreement = blocks.share;
  out.aligned = blocks.same >= kLeastBlocks && out.agreement >= kLeastAgreement;
  if (!out.aligned) return out;
  // Pixel centres: half a pixel is another part of a small picture.
  const double back_x = double(size.width) / small.width, back_y = double(size.height) / small.height;
  const cv::Matx33d to_small(1 / back_x, 0, 0.5 / back_x - 0.5, 0, 1 / back_y, 0.5 / back_y - 0.5, 0, 0, 1);
  const cv::Matx33d to_large(back_x, 0, 0.5 * back_x - 0.5, 0, back_y, 0.5 * back_y - 0.5, 0, 0, 1);
  const auto& m = *found;
  const cv::Matx33d whole(m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), 0, 0, 1);
  out.picture_from_reference = (to_large * whole * to_small).get_minor<2, 3>(0, 0);
  return out;
}

}  // namespace choreo::vision
