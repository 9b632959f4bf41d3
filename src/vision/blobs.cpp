// SPDX-License-Identifier: Apache-2.0
#include "vision/blobs.hpp"

#include <algorithm>
#include <cassert>

namespace choreo::vision {
namespace {

// Sums of k, k^2, k^3 over k = 0 .. n - 1.
constexpr std::int64_t sum1(std::int64_t n) { return n * (n - 1) / 2; }
constexpr std::int64_t sum2(std::int64_t n) { return n * (n - 1) * (2 * n - 1) / 6; }
constexpr std::int64_t sum3(std::int64_t n) { return sum1(n) * sum1(n); }

void check(const cv::Mat& mask) {
  assert(mask.empty() || mask.type() == CV_8UC1);
  assert(mask.cols <= kLongestSide && mask.rows <= kLongestSide);
  static_cast<void>(mask);
}

}  // namespace

void RawMoments::add(const Run& run) {
  assert(run.from >= 0 && run.from < run.to && run.to <= kLongestSide && run.y >= 0 && run.y < kLongestSide);
  const std::int64_t n = run.to - run.from;
  const std::int64_t y = run.y;
  const auto x1 = sum1(run.to) - sum1(run.from);
  const auto x2 = sum2(run.to) - sum2(run.from);
  const auto x3 = sum3(run.to) - sum3(run.from);
  m00_ += n;
  m10_ += x1;
  m01_ += n * y;
  m20_ += x2;
  m11_ += x1 * y;
  m02_ += n * y * y;
  m30_ += x3;
  m21_ += x2 * y;
  m12_ += x1 * y * y;
  m03_ += n * y * y * y;
}

void RawMoments::add(const RawMoments& other) {
  m00_ += other.m00_;
  m10_ += other.m10_;
  m01_ += other.m01_;
  m20_ += other.m20_;
  m11_ += other.m11_;
  m02_ += other.m02_;
  m30_ += other.m30_;
  m21_ += other.m21_;
  m12_ += other.m12_;
  m03_ += other.m03_;
}

Moments RawMoments::central() const {
  if (m00_ == 0) return {};
  const auto m = m00_;
  const auto cx = (2 * m10_ + m) / (2 * m);  // Nearest whole pixel; coordinates are not negative.
  const auto cy = (2 * m01_ + m) / (2 * m);
  // Sums about (cx, cy), exact.
  const auto s10 = m10_ - cx * m;
  const auto s01 = m01_ - cy * m;
  const auto s20 = m20_ - 2 * cx * m10_ + cx * cx * m;
  const auto s11 = m11_ - cx * m01_ - cy * m10_ + cx * cy * m;
  const auto s02 = m02_ - 2 * cy * m01_ + cy * cy * m;
  const auto s30 = m30_ - 3 * cx * m20_ + 3 * cx * cx * m10_ - cx * cx * cx * m;
  const auto s21 = m21_ - cy * m20_ - 2 * cx * m11_ + 2 * cx * cy * m10_ + cx * cx * m01_ - cx * cx * cy * m;
  const auto s12 = m12_ - cx * m02_ - 2 * cy * m11_ + 2 * cx * cy * m01_ + cy * cy * m10_ - cx * cy * cy * m;
  const auto s03 = m03_ - 3 * cy * m02_ + 3 * cy * cy * m01_ - cy * cy * cy * m;
  // And about the centroid, (fx, fy) further.
  const auto area = double(m);
  const double fx = double(s10) / area;
  const double fy = double(s01) / area;
  Moments c;
  c.m00 = area;
  c.centroid = {double(cx) + fx, double(cy) + fy};
  c.mu20 = double(s20) - area * fx * fx;
  c.mu11 = double(s11) - area * fx * fy;
  c.mu02 = double(s02) - area * fy * fy;
  c.mu30 = double(s30) - 3 * fx * double(s20) + 2 * area * fx * fx * fx;
  c.mu21 = double(s21) - 2 * fx * double(s11) - fy * double(s20) + 2 * area * fx * fx * fy;
  c.mu12 = double(s12) - 2 * fy * double(s11) - fx * double(s02) + 2 * area * fx * fy * fy;
  c.mu03 = double(s03) - 3 * fy * double(s02) + 2 * area * fy * fy * fy;
  return c;
}

Moments moments_of(const cv::Mat& mask) {
  check(mask);
  RawMoments sums;
  for (int y = 0; y < mask.rows; ++y) {
    for_each_run(mask.ptr<std::uint8_t>(y), mask.cols, [&](int from, int to) { sums.add({y, from, to}); });
  }
  return sums.central();
}

Moments together(const Moments& a, const Moments& b) {
  if (a.m00 == 0) return b;
  if (b.m00 == 0) return a;
  Moments sum;
  sum.m00 = a.m00 + b.m00;
  sum.centroid = (a.m00 * a.centroid + b.m00 * b.centroid) / sum.m00;
  for (const auto* part : {&a, &b}) {
    const auto& p = *part;
    const double dx = p.centroid.x - sum.centroid.x;
    const double dy = p.centroid.y - sum.centroid.y;
    sum.mu20 += p.mu20 + p.m00 * dx * dx;
    sum.mu11 += p.mu11 + p.m00 * dx * dy;
    sum.mu02 += p.mu02 + p.m00 * dy * dy;
    sum.mu30 += p.mu30 + 3 * dx * p.mu20 + p.m00 * dx * dx * dx;
    sum.mu21 += p.mu21 + 2 * dx * p.mu11 + dy * p.mu20 + p.m00 * dx * dx * dy;
    sum.mu12 += p.mu12 + 2 * dy * p.mu11 + dx * p.mu02 + p.m00 * dx * dy * dy;
    sum.mu03 += p.mu03 + 3 * dy * p.mu02 + p.m00 * dy * dy * dy;
  }
  return sum;
}

Regions regions_of(const cv::Mat& mask, int least_area) {
  check(mask);
  const auto parts = parts_of(mask, Neighbours::kEight);
  std::vector<RawMoments> sums(parts.count);
  for (std::size_t k = 0; k < parts.runs.size(); ++k) sums[parts.part_of[k]].add(parts.runs[k]);
  Regions regions;
  std::vector<int> number(parts.count, -1);
  for (std::size_t k = 0; k < sums.size(); ++k) {
    if (sums[k].area() < least_area) continue;
    number[k] = int(regions.blobs.size());
    regions.blobs.push_back({sums[k].central(), {}});
  }
  regions.runs.resize(regions.blobs.size());
  for (std::size_t k = 0; k < parts.runs.size(); ++k) {
    const int n = number[parts.part_of[k]];
    if (n < 0) continue;
    const auto& run = parts.runs[k];
    regions.runs[std::size_t(n)].push_back(run);
    regions.blobs[std::size_t(n)].box |= cv::Rect(run.from, run.y, run.to - run.from, 1);
  }
  return regions;
}

void paint(std::span<const Run> runs, std::uint8_t value, cv::Mat& picture) {
  assert(picture.type() == CV_8UC1);
  for (const auto& run : runs) {
    std::fill(picture.ptr<std::uint8_t>(run.y) + run.from, picture.ptr<std::uint8_t>(run.y) + run.to, value);
  }
}

}  // namespace choreo::vision
