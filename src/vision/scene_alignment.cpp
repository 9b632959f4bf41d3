// SPDX-License-Identifier: Apache-2.0
#include "vision/scene_alignment.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace choreo::vision {
namespace {

constexpr int kSmallest = 32;         // Of a picture's side.
constexpr int kCoarseSide = 80;       // Of the copy on which every candidate is tried.
constexpr int kFineSide = 640;        // No level is finer: more pixels do not tell more about four numbers.
constexpr int kSketchSide = 40;       // Where a turn by 3 degrees moves the rim by a pixel.
constexpr double kShiftReach = 0.06;  // Of the side, for shifts.
constexpr std::size_t kTried = 5;     // Candidates.
constexpr int kSteps = 20;            // At most, a level.
constexpr double kNoise = 5;          // Grey levels: contrast below it is not made larger.
constexpr double kContrast = 20;      // Standard deviation of what has been evened.
constexpr double kTextured = 6;       // The same of a block that tells anything.
constexpr int kBlock = 32;            // Pixels of the finest level.
constexpr int kCells = 3;             // Of the picture, along each side.
constexpr int kLeastOfCell = 3;       // Textured blocks.
constexpr double kSame = 0.8;         // Correlation of a block with itself in another picture; of chance about 0.1.
constexpr double kLeastAgreement = 0.25;
constexpr int kLeastBlocks = 8;  // That agree.

// x' = (1 + a) x - b y + tx, y' = b x + (1 + a) y + ty, about the picture's middle, in pixels of some level.
struct Similarity {
  double a = 0, b = 0, tx = 0, ty = 0;

  [[nodiscard]] cv::Matx23d matrix(cv::Size size) const {
    const double cx = 0.5 * (size.width - 1);
    const double cy = 0.5 * (size.height - 1);
    return {1 + a, -b, tx - a * cx + b * cy, b, 1 + a, ty - b * cx - a * cy};
  }
};

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

struct Candidate {
  Similarity transform;
  double cost = 1e300;
};

// Mean distance of the two where they meet, what is far being cut off.
double cost_of(const cv::Mat& reference, const cv::Mat& picture, int dx, int dy) {
  double cost = 0;
  int count = 0;
  const int first = std::max(1, 1 - dx);
  const int last = reference.cols - 1 - std::max(0, dx);
  for (int y = std::max(1, 1 - dy); y < reference.rows - 1 - std::max(0, dy); ++y) {
    const auto* r = reference.ptr<float>(y);
    const auto* p = picture.ptr<float>(y + dy) + dx;
    for (int x = first; x < last; ++x) cost += std::min(kContrast, double(std::abs(r[x] - p[x])));
    count += std::max(0, last - first);
  }
  return count > 0 ? cost / count : 1e300;
}

// Tries every candidate on the coarsest level: the best shift of each scale and turn, the best of these first.
std::vector<Candidate> candidates_of(const Level& level) {
  const auto size = level.reference.size();
  const int reach_x = std::max(1, int(std::ceil(kShiftReach * size.width)));
  const int reach_y = std::max(1, int(std::ceil(kShiftReach * size.height)));
  std::vector<Candidate> out;
  for (const double scale : {0.0, -0.016, 0.016, -0.032, 0.032}) {
    for (const double turn : {0.0, -0.018, 0.018, -0.036, 0.036}) {
      const cv::Mat turned = warped(level.picture, Similarity{scale, turn, 0, 0}.matrix(size));
      Candidate best;
      for (int dy = -reach_y; dy <= reach_y; ++dy) {
        for (int dx = -reach_x; dx <= reach_x; ++dx) {
          const double cost = cost_of(level.reference, turned, dx, dy);
          if (cost < best.cost) best = {{scale, turn, double(dx), double(dy)}, cost};
        }
      }
      out.push_back(best);
    }
  }
  std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.cost < b.cost; });
  return out;
}

double median_of(std::vector<float>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Gauss-Newton on picture(W(x)) = gain reference(x) with Tukey's weights, from `start` on.
Similarity refined(const Level& level, Similarity start) {
  cv::Mat gradient_x, gradient_y;
  cv::Scharr(level.picture, gradient_x, CV_32F, 1, 0, 1.0 / 32);
  cv::Scharr(level.picture, gradient_y, CV_32F, 0, 1, 1.0 / 32);
  const auto size = level.reference.size();
  const double cx = 0.5 * (size.width - 1);
  const double cy = 0.5 * (size.height - 1);
  Similarity at = start;
  double gain = 1;
  std::vector<float> sizes;
  for (int step = 0; step < kSteps; ++step) {
    const auto matrix = at.matrix(size);
    const cv::Mat picture = warped(level.picture, matrix);
    const cv::Mat gx = warped(gradient_x, matrix);
    const cv::Mat gy = warped(gradient_y, matrix);
    const cv::Mat inside = covered(size, matrix);
    sizes.clear();
    for (int y = 0; y < size.height; y += 2) {
      const auto* r = level.reference.ptr<float>(y);
      const auto* p = picture.ptr<float>(y);
      const auto* in = inside.ptr<std::uint8_t>(y);
      const auto* x_slope = gx.ptr<float>(y);
      const auto* y_slope = gy.ptr<float>(y);
      for (int x = 0; x < size.width; x += 2) {
        // Flat parts agree whatever the transform and would make every edge an outlier.
        if (in[x] == 0 || std::abs(x_slope[x]) + std::abs(y_slope[x]) < 2) continue;
        sizes.push_back(std::abs(p[x] - float(gain) * r[x]));
      }
    }
    const double cut = 4.685 * std::max(1.0, 1.4826 * median_of(sizes));
    cv::Matx<double, 5, 5> normal = cv::Matx<double, 5, 5>::zeros();
    cv::Vec<double, 5> right = cv::Vec<double, 5>::all(0);
    for (int y = 0; y < size.height; ++y) {
      const auto* r = level.reference.ptr<float>(y);
      const auto* p = picture.ptr<float>(y);
      const auto* in = inside.ptr<std::uint8_t>(y);
      const auto* x_slope = gx.ptr<float>(y);
      const auto* y_slope = gy.ptr<float>(y);
      for (int x = 0; x < size.width; ++x) {
        if (in[x] == 0) continue;
        const double residual = p[x] - gain * r[x];
        const double share = residual / cut;
        if (std::abs(share) >= 1) continue;
        const double weight = (1 - share * share) * (1 - share * share);
        const double dx = x - cx;
        const double dy = y - cy;
        const std::array<double, 5> slope = {x_slope[x] * dx + y_slope[x] * dy, y_slope[x] * dx - x_slope[x] * dy,
                                             x_slope[x], y_slope[x], -r[x]};
        for (int i = 0; i < 5; ++i) {
          for (int k = i; k < 5; ++k) normal(i, k) += weight * slope[std::size_t(i)] * slope[std::size_t(k)];
          right[i] -= weight * slope[std::size_t(i)] * residual;
        }
      }
    }
    for (int i = 0; i < 5; ++i) {
      for (int k = 0; k < i; ++k) normal(i, k) = normal(k, i);
      normal(i, i) += 1e-6 * (normal(i, i) + 1);
    }
    cv::Vec<double, 5> change;
    if (!cv::solve(normal, right, change, cv::DECOMP_CHOLESKY)) return start;
    at.a += change[0];
    at.b += change[1];
    at.tx += change[2];
    at.ty += change[3];
    gain = std::clamp(gain + change[4], 0.3, 3.0);
    const bool lost = !std::isfinite(at.tx + at.ty + at.a + at.b) || std::abs(at.a) > 0.06 || std::abs(at.b) > 0.08 ||
                      std::abs(at.tx) > 0.1 * size.width || std::abs(at.ty) > 0.1 * size.height;
    if (lost) return start;
    const double moved = std::abs(change[2]) + std::abs(change[3]) +
                         (std::abs(change[0]) + std::abs(change[1])) * 0.5 * std::max(size.width, size.height);
    if (moved < 0.01) break;
  }
  return at;
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
  // From the finest to the coarsest, each half as large.
  std::vector<cv::Size> sizes = {size};
  if (longer > kFineSide) {
    const double shrink = double(kFineSide) / longer;
    sizes.front() = {std::max(kSmallest, cvRound(size.width * shrink)),
                     std::max(kSmallest, cvRound(size.height * shrink))};
  }
  while (std::max(sizes.back().width, sizes.back().height) > 3 * kCoarseSide / 2) {
    sizes.emplace_back((sizes.back().width + 1) / 2, (sizes.back().height + 1) / 2);
  }
  std::vector<Level> levels;
  for (const auto& level : sizes) {
    const double sigma = std::max(level.width, level.height) / 20.0;
    levels.push_back({evened(luminance(reference, level), sigma), evened(luminance(picture, level), sigma)});
  }
  const auto finer = [&](Similarity transform, std::size_t from, std::size_t to) {
    transform.tx *= double(sizes[to].width) / sizes[from].width;
    transform.ty *= double(sizes[to].height) / sizes[from].height;
    return refined(levels[to], transform);
  };
  // A body that moves, or a curtain of even folds, misleads the smallest copy; on the next one the right start shows.
  const auto coarsest = levels.size() - 1;
  const auto next = coarsest > 0 ? coarsest - 1 : 0;
  auto candidates = candidates_of(levels[coarsest]);
  candidates.resize(kTried);
  for (auto& candidate : candidates) {
    candidate.transform = finer(finer(candidate.transform, coarsest, coarsest), coarsest, next);
    const cv::Mat moved = warped(levels[next].picture, candidate.transform.matrix(sizes[next]));
    candidate.cost = cost_of(levels[next].reference, moved, 0, 0);
  }
  auto found = std::min_element(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
                 return a.cost < b.cost;
               })->transform;
  for (auto k = next; k-- > 0;) found = finer(found, k + 1, k);
  const auto blocks = agreement_of(levels.front(), found.matrix(sizes.front()));
  out.agreement = blocks.share;
  out.aligned = blocks.same >= kLeastBlocks && out.agreement >= kLeastAgreement;
  if (!out.aligned) return out;
  found.tx *= double(size.width) / sizes.front().width;
  found.ty *= double(size.height) / sizes.front().height;
  out.picture_from_reference = found.matrix(size);
  return out;
}

}  // namespace choreo::vision
