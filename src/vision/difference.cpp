// SPDX-License-Identifier: Apache-2.0
#include "vision/difference.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <vector>

#include <tbb/parallel_invoke.h>
#include <opencv2/imgproc.hpp>

#include "vision/runs.hpp"

namespace choreo::vision {
namespace {

// Outside the picture lies what is neutral in a dilation and in an erosion (OpenCV's default value of a constant
// border), also where the picture is a part of a larger one.
constexpr int kNeutralOutside = cv::BORDER_CONSTANT | cv::BORDER_ISOLATED;

void grow(const cv::Mat& in, cv::Mat& out, const cv::Mat& square) {
  cv::dilate(in, out, square, {-1, -1}, 1, kNeutralOutside);
}

void shrink(const cv::Mat& in, cv::Mat& out, const cv::Mat& square) {
  cv::erode(in, out, square, {-1, -1}, 1, kNeutralOutside);
}

// The areas of the parts, in pixels.
std::vector<std::int64_t> areas_of(const Parts& parts) {
  std::vector<std::int64_t> areas(parts.count, 0);
  for (std::size_t k = 0; k < parts.runs.size(); ++k) areas[parts.part_of[k]] += parts.runs[k].to - parts.runs[k].from;
  return areas;
}

// A mask of the parts for which stays(part) holds.
template <typename Stays>
cv::Mat drawn(const Parts& parts, cv::Size size, Stays stays) {
  cv::Mat out = cv::Mat::zeros(size, CV_8UC1);
  for (std::size_t k = 0; k < parts.runs.size(); ++k) {
    const auto& run = parts.runs[k];
    if (!stays(parts.part_of[k])) continue;
    std::fill(out.ptr<std::uint8_t>(run.y) + run.from, out.ptr<std::uint8_t>(run.y) + run.to, std::uint8_t(255));
  }
  return out;
}

}  // namespace

cv::Rect around(const cv::Mat& mask, int margin) {
  const auto box = cv::boundingRect(mask);
  if (box.empty()) return {};
  return cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
         cv::Rect({0, 0}, mask.size());
}

cv::Mat difference_luminance(const cv::Mat& picture, const cv::Mat& background) {
  assert(picture.type() == CV_8UC3 && background.type() == CV_8UC3 && picture.size() == background.size());
  constexpr int kRows = 32;  // What is between the two steps stays in the cache.
  cv::Mat difference;
  cv::Mat luminance(picture.size(), CV_8UC1);
  for (int y = 0; y < picture.rows; y += kRows) {
    const cv::Range rows(y, std::min(y + kRows, picture.rows));
    cv::absdiff(picture.rowRange(rows), background.rowRange(rows), difference);
    cv::Mat out = luminance.rowRange(rows);
    cv::cvtColor(difference, out, cv::COLOR_BGR2GRAY);  // These are its weights.
  }
  return luminance;
}

double interpolated_median(const cv::Mat& grey) {
  std::array<std::int64_t, 256> histogram{};
  for (int y = 0; y < grey.rows; ++y) {
    const auto* line = grey.ptr<std::uint8_t>(y);
    for (int x = 0; x < grey.cols; ++x) ++histogram[line[x]];
  }
  const double half = double(grey.total()) / 2.0;
  double below = 0;
  for (int level = 0; level < 256; ++level) {
    const auto here = double(histogram[std::size_t(level)]);
    if (below + here >= half) return std::max(0.0, level - 0.5 + (half - below) / std::max(1.0, here));
    below += here;
  }
  return 255.0;
}

cv::Mat annealed(const cv::Mat& mask, int steps) {
  assert(steps >= 0);
  if (steps == 0) return mask.clone();
  // n steps of the 3 x 3 square are one of the (2n+1) x (2n+1) square.
  const cv::Mat square = cv::getStructuringElement(cv::MORPH_RECT, {2 * steps + 1, 2 * steps + 1});
  cv::Mat out = cv::Mat::zeros(mask.size(), CV_8UC1);
  // As far as it grows, and as far as that is looked at when it shrinks.
  const auto box = around(mask, 2 * steps);
  if (box.empty()) return out;
  cv::Mat grown;
  grow(mask(box), grown, square);
  cv::Mat part = out(box);
  shrink(grown, part, square);
  return out;
}

namespace {

// Of a row: what is neither inside nor differs enough goes.
template <int halvings>
void drop_faint(std::uint8_t* __restrict mask, const std::uint8_t* __restrict inside,
                const std::uint8_t* __restrict difference, const std::uint8_t* __restrict strongest, int count) {
  constexpr std::uint8_t kRest = (1 << halvings) - 1;
  for (int x = 0; x < count; ++x) {
    // In bytes: the loop is vector code.
    const auto enough = static_cast<std::uint8_t>((strongest[x] >> halvings) + ((strongest[x] & kRest) != 0 ? 1 : 0));
    const auto stays = static_cast<std::uint8_t>(difference[x] >= enough ? 255 : 0);
    mask[x] = static_cast<std::uint8_t>(mask[x] & (inside[x] | stays));
  }
}

// Takes the pixels away from the mask's edge that differ less than 2^-`halvings` as much as the body within `reach`
// pixels.
template <int halvings>
void drop_faint_edge(cv::Mat mask, const cv::Mat& difference, int reach) {
  const cv::Mat square = cv::getStructuringElement(cv::MORPH_RECT, {3, 3});
  cv::Mat inside;
  cv::Mat strongest;
  tbb::parallel_invoke(
      // Outside the picture counts as body: a body cut by the frame has no edge there.
      [&] { shrink(mask, inside, square); },
      [&] {
        cv::Mat body_difference;
        cv::bitwise_and(difference, mask, body_difference);
        grow(body_difference, strongest, cv::getStructuringElement(cv::MORPH_RECT, {2 * reach + 1, 2 * reach + 1}));
      });
  for (int y = 0; y < mask.rows; ++y) {
    drop_faint<halvings>(mask.ptr<std::uint8_t>(y), inside.ptr<std::uint8_t>(y), difference.ptr<std::uint8_t>(y),
                         strongest.ptr<std::uint8_t>(y), mask.cols);
  }
}

}  // namespace

cv::Mat edge_at_half_contrast(const cv::Mat& mask, const cv::Mat& difference) {
  assert(mask.type() == CV_8UC1 && difference.type() == CV_8UC1 && mask.size() == difference.size());
  cv::Mat out = mask.clone();
  if (const auto box = around(mask, 1); !box.empty()) drop_faint_edge<1>(out(box), difference(box), 1);
  return out;
}

cv::Mat without_halo(const cv::Mat& mask, const cv::Mat& difference) {
  assert(mask.type() == CV_8UC1 && difference.type() == CV_8UC1 && mask.size() == difference.size());
  cv::Mat out = mask.clone();
  if (const auto box = around(mask, 1); !box.empty()) {
    for (int pixel = 0; pixel < 2; ++pixel) drop_faint_edge<2>(out(box), difference(box), 2);
  }
  return out;
}

cv::Mat without_specks(const cv::Mat& mask, int min_area, bool only_largest) {
  if (min_area <= 1 && !only_largest) return mask.clone();
  const auto parts = parts_of(mask, Neighbours::kEight);
  const auto area = areas_of(parts);
  const auto largest = static_cast<std::size_t>(std::max_element(area.begin(), area.end()) - area.begin());
  return drawn(parts, mask.size(),
               [&](std::size_t part) { return area[part] >= min_area && (!only_largest || part == largest); });
}

cv::Mat closed_by_disc(const cv::Mat& mask, double radius) {
  assert(radius >= 2);
  cv::Mat out = cv::Mat::zeros(mask.size(), CV_8UC1);
  // A step to the side counts 0.955. Beyond what is grown there must be something that is not.
  const auto box = around(mask, 2 + static_cast<int>(radius / 0.955));
  if (box.empty()) return out;
  cv::Mat distance;
  cv::distanceTransform(~mask(box), distance, cv::DIST_L2, 3);
  const cv::Mat grown = distance <= radius;
  cv::distanceTransform(grown, distance, cv::DIST_L2, 3);
  cv::Mat part = out(box);
  cv::compare(distance, radius - 2.0, part, cv::CMP_GT);
  return out;
}

cv::Mat without_small_holes(const cv::Mat& mask, int max_area) {
  cv::Mat labels;
  cv::Mat statistics;
  cv::Mat centroids;
  const int count = cv::connectedComponentsWithStats(~mask, labels, statistics, centroids, 4, CV_32S, cv::CCL_SAUF);
  std::vector<std::uint8_t> fill(static_cast<std::size_t>(count), 0);
  for (int i = 1; i < count; ++i) {
    const int left = statistics.at<int>(i, cv::CC_STAT_LEFT);
    const int top = statistics.at<int>(i, cv::CC_STAT_TOP);
    const bool inside = left > 0 && top > 0 && left + statistics.at<int>(i, cv::CC_STAT_WIDTH) < mask.cols &&
                        top + statistics.at<int>(i, cv::CC_STAT_HEIGHT) < mask.rows;
    fill[std::size_t(i)] = inside && statistics.at<int>(i, cv::CC_STAT_AREA) <= max_area ? 255 : 0;
  }
  cv::Mat out = mask.clone();
  for (int y = 0; y < mask.rows; ++y) {
    const auto* label = labels.ptr<int>(y);
    auto* o = out.ptr<std::uint8_t>(y);
    for (int x = 0; x < mask.cols; ++x) o[x] |= fill[std::size_t(label[x])];
  }
  return out;
}

cv::Mat hull_of(const cv::Mat& mask) {
  std::vector<cv::Point> points;
  cv::findNonZero(mask, points);
  cv::Mat hull = cv::Mat::zeros(mask.size(), CV_8UC1);
  if (points.empty()) return hull;
  std::vector<cv::Point> outline;
  cv::convexHull(points, outline);
  cv::fillConvexPoly(hull, outline, 255);
  return hull;
}

}  // namespace choreo::vision
