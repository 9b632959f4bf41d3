// SPDX-License-Identifier: Apache-2.0
#include "vision/camera_motion.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "vision/difference.hpp"
#include "vision/tone_curve.hpp"

namespace choreo::vision {
namespace {

constexpr int kCorners = 300;
constexpr int kLeastCorners = 12;  // That agree.
constexpr int kLevels = 3;
const cv::Size kWindow(15, 15);

cv::Mat one_channel(const cv::Mat& picture) {
  if (picture.channels() == 1) return picture;
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

std::vector<cv::Mat> pyramid_of(const cv::Mat& grey) {
  std::vector<cv::Mat> pyramid;
  cv::buildOpticalFlowPyramid(grey, pyramid, kWindow, kLevels);
  return pyramid;
}

}  // namespace

CameraMotion::CameraMotion(const cv::Mat& reference, const cv::Mat& covered) {
  assert(reference.type() == CV_8UC3 || reference.type() == CV_8UC1);
  const auto grey = one_channel(reference);
  pyramid_ = pyramid_of(grey);
  cv::Mat room;
  if (!covered.empty()) room = ~covered;
  constexpr double kQuality = 0.04;
  const double apart = std::max(3.0, reference.rows / 40.0);
  cv::goodFeaturesToTrack(grey, corners_, kCorners, kQuality, apart, room);
}

bool CameraMotion::can_tell() const { return corners_.size() >= kLeastCorners; }

std::optional<CameraShift> CameraMotion::of(const cv::Mat& picture, const CameraShift& guess, double stands_px) const {
  if (!can_tell()) return std::nullopt;
  const auto now = pyramid_of(one_channel(picture));
  std::vector<cv::Point2f> found;
  cv::transform(corners_, found, guess);
  std::vector<std::uint8_t> good;
  cv::calcOpticalFlowPyrLK(pyramid_, now, corners_, found, good, cv::noArray(), kWindow, kLevels,
                           {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.01}, cv::OPTFLOW_USE_INITIAL_FLOW);
  std::vector<cv::Point2f> from, to;
  for (std::size_t k = 0; k < corners_.size(); ++k) {
    if (good[k] == 0) continue;
    from.push_back(corners_[k]);
    to.push_back(found[k]);
  }
  if (from.size() < kLeastCorners) return std::nullopt;
  constexpr double kAgree_px = 1;
  std::vector<std::uint8_t> agree;
  const cv::Mat fit = cv::estimateAffinePartial2D(from, to, agree, cv::RANSAC, kAgree_px);
  const auto count = std::ranges::count(agree, 1);
  if (fit.empty() || count < kLeastCorners || 4 * count < std::ptrdiff_t(corners_.size())) return std::nullopt;
  // Of two explanations as good the simpler one: what is fitted to a few corners is far off elsewhere.
  constexpr double kAsGood = 0.8;
  std::ptrdiff_t stand = 0;
  for (std::size_t k = 0; k < from.size(); ++k) stand += cv::norm(to[k] - from[k]) < stands_px ? 1 : 0;
  if (double(stand) >= kAsGood * double(count)) return kNoShift;
  return CameraShift(fit);
}

bool explains(std::span<const std::optional<CameraShift>> shifts, std::span<const cv::Mat> pictures,
              const cv::Mat& reference) {
  assert(shifts.size() == pictures.size());
  constexpr int kCells = 3;        // Along each side.
  constexpr double kDiffers = 20;  // Grey levels.
  constexpr double kSome = 0.002;  // Of a cell: an edge of a picture frame.
  constexpr double kLeft = 0.6;    // Of what differs; noise and bodies stay.
  std::array<double, kCells * kCells> before{}, after{};
  const auto add = [&](const cv::Mat& picture, const cv::Mat& lit, std::array<double, kCells * kCells>& sums) {
    const cv::Mat differs = difference_luminance(picture, lit) > kDiffers;
    for (int k = 0; k < kCells * kCells; ++k) {
      const int x = k % kCells, y = k / kCells;
      const cv::Range rows(y * differs.rows / kCells, (y + 1) * differs.rows / kCells);
      const cv::Range cols(x * differs.cols / kCells, (x + 1) * differs.cols / kCells);
      sums[std::size_t(k)] += cv::countNonZero(differs(rows, cols)) / double(std::max(1, rows.size() * cols.size()));
    }
  };
  int moved = 0;
  for (std::size_t k = 0; k < pictures.size(); ++k) {
    if (!shifts[k] || shifts[k] == kNoShift) continue;
    const auto back = brought_back(pictures[k], *shifts[k], reference);
    const auto lit = ToneCurve(reference, back).apply(reference);
    add(pictures[k], lit, before);
    add(back, lit, after);
    ++moved;
  }
  int parts = 0, explained = 0;
  for (std::size_t k = 0; k < before.size(); ++k) {
    if (before[k] <= kSome * moved) continue;
    ++parts;
    explained += after[k] < kLeft * before[k] ? 1 : 0;
  }
  return 2 * explained > parts;
}

CameraKind kind_of(std::span<const std::optional<CameraShift>> shifts, bool explained) {
  constexpr double kBlows = 0.2;  // Of the pictures; a blow at the tripod is no shaking.
  constexpr double kMost = 2.0 / 3;
  const auto found = std::ranges::count_if(shifts, [](const auto& shift) { return shift.has_value(); });
  if (double(found) < kMost * double(shifts.size())) return CameraKind::kMayMove;
  const auto still = std::ranges::count(shifts, std::optional(kNoShift));
  const bool moved = double(found - still) > kBlows * double(found);
  return moved && explained ? CameraKind::kShakes : CameraKind::kStill;
}

cv::Mat brought_back(const cv::Mat& picture, const CameraShift& shift, const cv::Mat& beyond) {
  if (shift == kNoShift) return picture;
  cv::Mat out = beyond.clone();
  cv::warpAffine(picture, out, shift, picture.size(), cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_TRANSPARENT);
  return out;
}

cv::Mat taken_along(const cv::Mat& mask, const CameraShift& shift, const cv::Mat& beyond) {
  if (shift == kNoShift) return mask;
  cv::Mat out = beyond.clone();
  cv::warpAffine(mask, out, shift, mask.size(), cv::INTER_LINEAR, cv::BORDER_TRANSPARENT);
  return out >= 128;
}

}  // namespace choreo::vision
