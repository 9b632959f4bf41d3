// SPDX-License-Identifier: Apache-2.0
#include "devices/synthetic/brush.hpp"

#include <algorithm>
#include <cassert>

namespace choreo::devices::synthetic {
namespace {

cv::Vec4b solid(const cv::Vec3f& colour) {
  const auto byte = [](float v) { return static_cast<unsigned char>(std::clamp(v, 0.0F, 255.0F) + 0.5F); };
  return {byte(colour[0]), byte(colour[1]), byte(colour[2]), 1};
}

}  // namespace

Profile::Profile(std::initializer_list<std::pair<double, double>> points) {
  assert(points.size() >= 2);
  const auto* p = points.begin();
  const auto last = points.size() - 1;
  std::size_t k = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double u = static_cast<double>(i) / kSteps;
    while (k + 1 < last && u > p[k + 1].first) ++k;
    // A cubic through the two neighbours whose slopes are those of the chords around them.
    const auto& [u0, w0] = p[k];
    const auto& [u1, w1] = p[k + 1];
    const double h = u1 - u0;
    const double chord = (w1 - w0) / h;
    const double slope0 = k > 0 ? (w1 - p[k - 1].second) / (u1 - p[k - 1].first) : chord;
    const double slope1 = k + 1 < last ? (p[k + 2].second - w0) / (p[k + 2].first - u0) : chord;
    const double t = std::clamp((u - u0) / h, 0.0, 1.0);
    half_[static_cast<std::size_t>(i)] = (1 + 2 * t) * (1 - t) * (1 - t) * w0 + t * (1 - t) * (1 - t) * h * slope0 +
                                         t * t * (3 - 2 * t) * w1 - t * t * (1 - t) * h * slope1;
  }
}

double Profile::at(double share) const {
  const double place = std::clamp(share, 0.0, 1.0) * kSteps;
  const int i = std::min(static_cast<int>(place), kSteps - 1);
  const double t = place - i;
  return (1 - t) * half_[static_cast<std::size_t>(i)] + t * half_[static_cast<std::size_t>(i) + 1];
}

double light_on(cv::Point2d side, double across) {
  // The light comes from the viewer's upper left and front; a bright room leaves no side dark.
  constexpr double kLightX = -0.42, kLightY = -0.50, kLightZ = 0.757, kAmbient = 0.60, kDirect = 0.46;
  const double towards_viewer = std::sqrt(std::max(0.0, 1 - across * across));
  const double facing = across * (side.x * kLightX + side.y * kLightY) + towards_viewer * kLightZ;
  return kAmbient + kDirect * std::max(0.0, facing);
}

void Brush::begin(const cv::Rect& box, int fine) {
  box_ = box;
  fine_ = fine;
  mark_ = 1;
  samples_.create(box.height * fine, box.width * fine);
  samples_.setTo(cv::Scalar::all(0));
  extents_.assign(static_cast<std::size_t>(samples_.rows), {samples_.cols, 0});
}

template <typename Colour>
void Brush::fill(const Stroke& stroke, const Colour& colour) {
  const double f = fine_;
  // In samples, whose centres are at half numbers.
  const cv::Point2d a((stroke.a.x - box_.x) * f, (stroke.a.y - box_.y) * f);
  const cv::Point2d b((stroke.b.x - box_.x) * f, (stroke.b.y - box_.y) * f);
  const double length = std::hypot(b.x - a.x, b.y - a.y);
  const cv::Point2d along = length > 1e-9 ? (b - a) / length : cv::Point2d(0, 1);
  const cv::Point2d side(-along.y, along.x);
  std::array<double, Profile::kSteps + 1> half{};
  double widest = 0;
  for (int i = 0; i <= Profile::kSteps; ++i) {
    auto& w = half[static_cast<std::size_t>(i)];
    w = stroke.profile->at(static_cast<double>(i) / Profile::kSteps) * stroke.scale * f;
    widest = std::max(widest, w);
  }
  const double start = stroke.round_a ? half.front() : 0;
  const double end = stroke.round_b ? half.back() : 0;
  const auto first_row = static_cast<int>(std::floor(std::min(a.y, b.y) - widest));
  const auto last_row = static_cast<int>(std::ceil(std::max(a.y, b.y) + widest));
  const auto first_col = static_cast<int>(std::floor(std::min(a.x, b.x) - widest));
  const auto last_col = static_cast<int>(std::ceil(std::max(a.x, b.x) + widest));
  const double per_length = length > 1e-9 ? 1 / length : 0;
  for (int y = std::max(0, first_row); y <= std::min(samples_.rows - 1, last_row); ++y) {
    auto* row = samples_[y];
    auto& extent = extents_[static_cast<std::size_t>(y)];
    const double dy = y + 0.5 - a.y;
    // Only columns within the widest distance from the axis can be inside.
    int from = std::max(0, first_col);
    int to = std::min(samples_.cols - 1, last_col);
    if (std::abs(side.x) > 0.05) {
      const double middle = a.x - dy * side.y / side.x;
      const double reach = (widest + 1) / std::abs(side.x);
      from = std::max(from, static_cast<int>(std::floor(middle - reach)));
      to = std::min(to, static_cast<int>(std::ceil(middle + reach)));
    }
    for (int x = from; x <= to; ++x) {
      const double dx = x + 0.5 - a.x;
      const double forward = dx * along.x + dy * along.y;
      const double lateral = dx * side.x + dy * side.y;
      double w = 0;
      if (forward < 0) {
        if (forward < -start || forward * forward + lateral * lateral > start * start) continue;
        w = start;
      } else if (forward > length) {
        const double beyond = forward - length;
        if (beyond > end || beyond * beyond + lateral * lateral > end * end) continue;
        w = end;
      } else {
        const double place = forward * per_length * Profile::kSteps;
        const int i = std::min(static_cast<int>(place), Profile::kSteps - 1);
        const double t = place - i;
        w = (1 - t) * half[static_cast<std::size_t>(i)] + t * half[static_cast<std::size_t>(i) + 1];
        if (std::abs(lateral) > w) continue;
      }
      row[x] = colour(w > 0 ? lateral / w : 0.0, forward * per_length);
      row[x][3] = mark_;
      extent.first = std::min(extent.first, x);
      extent.second = std::max(extent.second, x + 1);
    }
  }
}

void Brush::draw(const Stroke& stroke) {
  const double length = std::hypot(stroke.b.x - stroke.a.x, stroke.b.y - stroke.a.y);
  const cv::Point2d along = length > 1e-9 ? (stroke.b - stroke.a) / length : cv::Point2d(0, 1);
  const cv::Point2d side(-along.y, along.x);
  constexpr int kShades = 64;
  std::array<cv::Vec4b, kShades + 1> shades;
  for (int i = 0; i <= kShades; ++i) {
    const double across = (2.0 * i / kShades - 1) * stroke.roundness;
    shades[static_cast<std::size_t>(i)] = solid(stroke.colour * (light_on(side, across) * stroke.light));
  }
  fill(stroke, [&](double across, double) {
    return shades[static_cast<std::size_t>((std::clamp(across, -1.0, 1.0) + 1) * (kShades / 2) + 0.5)];
  });
}

void Brush::draw(const Stroke& stroke, const Shader& shader) {
  fill(stroke, [&](double across, double share) { return solid(shader(across, share)); });
}

void Brush::ellipse(cv::Point2d centre, double half_width, double half_height, cv::Vec3f colour) {
  // Thickness of an ellipse along its vertical axis, from top to bottom.
  static const Profile kRound = {{0, 0.001},    {0.01, 0.199}, {0.03, 0.341}, {0.07, 0.510}, {0.13, 0.673},
                                 {0.2, 0.8},    {0.35, 0.954}, {0.5, 1},      {0.65, 0.954}, {0.8, 0.8},
                                 {0.87, 0.673}, {0.93, 0.510}, {0.97, 0.341}, {0.99, 0.199}, {1, 0.001}};
  const Stroke stroke{{centre.x, centre.y - half_height},
                      {centre.x, centre.y + half_height},
                      &kRound,
                      half_width,
                      false,
                      false,
                      colour};
  const auto flat = solid(colour);
  fill(stroke, [&](double, double) { return flat; });
}

std::array<int, 4> Brush::pixel(int x, int y) const {
  std::array<int, 4> sum{};
  for (int j = 0; j < fine_; ++j) {
    const auto* s = samples_[(y - box_.y) * fine_ + j] + (x - box_.x) * fine_;
    for (int i = 0; i < fine_; ++i) {
      for (int c = 0; c < 3; ++c) sum[static_cast<std::size_t>(c)] += s[i][c];
      sum[3] += s[i][3] != 0 ? 1 : 0;
    }
  }
  return sum;
}

int Brush::marked(int x, int y, unsigned char mark) const {
  int count = 0;
  for (int j = 0; j < fine_; ++j) {
    const auto* s = samples_[(y - box_.y) * fine_ + j] + (x - box_.x) * fine_;
    for (int i = 0; i < fine_; ++i) count += s[i][3] == mark ? 1 : 0;
  }
  return count;
}

std::pair<int, int> Brush::extent(int y) const {
  int first = samples_.cols;
  int last = 0;
  for (int j = 0; j < fine_; ++j) {
    const auto& e = extents_[static_cast<std::size_t>((y - box_.y) * fine_ + j)];
    first = std::min(first, e.first);
    last = std::max(last, e.second);
  }
  if (first >= last) return {0, 0};
  return {box_.x + first / fine_, box_.x + (last + fine_ - 1) / fine_};
}

}  // namespace choreo::devices::synthetic
