// SPDX-License-Identifier: Apache-2.0
#include "body/mask_state.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "vision/runs.hpp"

namespace choreo::body {
namespace {

// floor(a / b) for b > 0; C++ division rounds towards zero.
constexpr std::int64_t floor_div(std::int64_t a, std::int64_t b) {
  const auto quotient = a / b;
  return quotient * b > a ? quotient - 1 : quotient;
}

}  // namespace

MaskState::MaskState(const cv::Mat& mask) {
  assert(mask.type() == CV_8UC1);
  std::int64_t sum_x = 0;
  std::int64_t sum_y = 0;
  int x0 = mask.cols;
  int x1 = -1;
  int y0 = mask.rows;
  int y1 = -1;
  for (int y = 0; y < mask.rows; ++y) {
    std::int64_t in_row = 0;
    vision::for_each_run(mask.ptr<std::uint8_t>(y), mask.cols, [&](int from, int to) {
      in_row += to - from;
      sum_x += (std::int64_t{to} * (to - 1) - std::int64_t{from} * (from - 1)) / 2;
      x0 = std::min(x0, from);
      x1 = std::max(x1, to - 1);
    });
    if (in_row == 0) continue;
    area_ += in_row;
    sum_y += in_row * y;
    y0 = std::min(y0, y);
    y1 = y;
  }
  assert(area_ > 0);
  // floor(sum / M + 1/2) without leaving the integers.
  center_ = {static_cast<int>(floor_div(2 * sum_x + area_, 2 * area_)),
             static_cast<int>(floor_div(2 * sum_y + area_, 2 * area_))};
  remainder_x_ = sum_x - center_.x * area_;
  centroid_ = {double(sum_x) / double(area_), double(sum_y) / double(area_)};
  box_ = cv::Rect(x0 - center_.x, y0 - center_.y, x1 - x0 + 1, y1 - y0 + 1);
  row_words_ = (std::size_t(box_.width) + 63) / 64;
  words_.assign(row_words_ * std::size_t(box_.height), 0);
  for (int y = y0; y <= y1; ++y) {
    vision::for_each_run(mask.ptr<std::uint8_t>(y), mask.cols, [&](int from, int to) {
      for (int x = from; x < to; ++x) set(x - center_.x, y - center_.y);
    });
  }
}

bool MaskState::at(int x, int y) const {
  if (!box_.contains({x, y})) return false;
  const auto k = std::size_t(x - box_.x);
  return ((row(y)[k / 64] >> (k % 64)) & 1) != 0;
}

void MaskState::set(int x, int y) {
  const auto k = std::size_t(x - box_.x);
  words_[std::size_t(y - box_.y) * row_words_ + k / 64] |= std::uint64_t{1} << (k % 64);
}

MaskState mirrored(const MaskState& a) {
  // The mirror image lies at -u; its centroid's remainder is -f. Where that is 1/2 it would round to the next pixel:
  // then the mirror stands half a pixel further to the left, C stays, and every relative coordinate is one less.
  MaskState m;
  m.area_ = a.area_;
  m.center_ = a.center_;
  m.remainder_x_ = -a.remainder_x_;
  int carry = 0;
  if (2 * m.remainder_x_ >= m.area_) {
    m.remainder_x_ -= m.area_;
    carry = 1;
  }
  m.centroid_ = {2.0 * a.center_.x - carry - a.centroid_.x, a.centroid_.y};
  m.box_ = cv::Rect(-(a.box_.x + a.box_.width - 1) - carry, a.box_.y, a.box_.width, a.box_.height);
  m.row_words_ = a.row_words_;
  m.words_.assign(a.words_.size(), 0);
  for (int y = a.box_.y; y < a.box_.y + a.box_.height; ++y) {
    for (int x = a.box_.x; x < a.box_.x + a.box_.width; ++x) {
      if (a.at(x, y)) m.set(-x - carry, y);
    }
  }
  return m;
}

int mirror_shift(std::int64_t remainder_a, std::int64_t area_a, std::int64_t remainder_b, std::int64_t area_b) {
  // floor(ra/Ma + rb/Mb + 1/2) = floor((2 (ra Mb + rb Ma) + Ma Mb) / (2 Ma Mb)), which is -1, 0 or 1: two comparisons
  // instead of a division, since every pair asks. Areas under 2^30 cannot overflow.
  const auto below = 2 * area_a * area_b;
  const auto sum = 2 * (remainder_a * area_b + remainder_b * area_a) + area_a * area_b;
  return sum < 0 ? -1 : sum >= below ? 1 : 0;
}

double similarity_of_counts(std::int64_t common, std::int64_t area_a, std::int64_t area_b) {
  return double(common) / std::sqrt(double(area_a) * double(area_b));
}

double similarity(const MaskState& a, const MaskState& b) {
  std::int64_t common = 0;
  const auto box = a.box() & b.box();
  for (int y = box.y; y < box.y + box.height; ++y) {
    for (int x = box.x; x < box.x + box.width; ++x) common += a.at(x, y) && b.at(x, y) ? 1 : 0;
  }
  return similarity_of_counts(common, a.area(), b.area());
}

double mirror_similarity(const MaskState& a, const MaskState& b) {
  const int sigma = mirror_shift(a.remainder_x(), a.area(), b.remainder_x(), b.area());
  std::int64_t common = 0;
  const auto box = b.box();
  for (int y = box.y; y < box.y + box.height; ++y) {
    for (int x = box.x; x < box.x + box.width; ++x) common += a.at(sigma - x, y) && b.at(x, y) ? 1 : 0;
  }
  return similarity_of_counts(common, a.area(), b.area());
}

}  // namespace choreo::body
