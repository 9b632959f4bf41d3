// SPDX-License-Identifier: Apache-2.0
#include "pipeline/working_size.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>
#include <opencv2/imgproc.hpp>

namespace choreo::pipeline {
namespace {

// The largest number of bands of whole rows, each reduced from whole rows, that give the same bits as all at once.
// Where a row is made of p/q rows and q is a power of two, its place and weights are exact; else they depend on how far
// down it is.
int exact_bands(cv::Size from, cv::Size to) {
  if (to.height < 1 || to.height > from.height || to.width > from.width) return 1;
  const int bands = std::gcd(from.height, to.height);
  const int q = to.height / bands;
  return (q & (q - 1)) == 0 ? bands : 1;
}

}  // namespace

cv::Size working_size(cv::Size picture, int rows) {
  if (rows <= 0 || picture.height <= rows) return picture;
  const auto width = std::lround(double(picture.width) * rows / picture.height);
  return {std::max(1, static_cast<int>(width)), rows};
}

cv::Mat at_working_size(const cv::Mat& picture, cv::Size size) {
  if (picture.size() == size) return picture;
  cv::Mat out(size, picture.type());
  const int bands = exact_bands(picture.size(), size);
  const int from_rows = picture.rows / bands;
  const int to_rows = size.height / bands;
  constexpr int kRowsAtATime = 64;  // Of the large picture: less is not worth handing over.
  const auto at_a_time = std::size_t(std::max(1, kRowsAtATime / std::max(1, from_rows)));
  tbb::parallel_for(tbb::blocked_range<int>(0, bands, at_a_time), [&](const tbb::blocked_range<int>& some) {
    auto rows = out.rowRange(some.begin() * to_rows, some.end() * to_rows);
    cv::resize(picture.rowRange(some.begin() * from_rows, some.end() * from_rows), rows, rows.size(), 0, 0,
               cv::INTER_AREA);
  });
  return out;
}

cv::Mat grey_part(const cv::Mat& bgr, cv::Size size, const cv::Rect& where) {
  cv::Mat part;
  if (bgr.size() == size) {
    part = bgr(where);
  } else {
    const double sx = double(bgr.cols) / size.width;
    const double sy = double(bgr.rows) / size.height;
    const cv::Point from(static_cast<int>(where.x * sx), static_cast<int>(where.y * sy));
    const cv::Point to(static_cast<int>(std::ceil(where.br().x * sx)), static_cast<int>(std::ceil(where.br().y * sy)));
    cv::resize(bgr(cv::Rect(from, to) & cv::Rect({0, 0}, bgr.size())), part, where.size(), 0, 0, cv::INTER_AREA);
  }
  cv::Mat grey;
  cv::cvtColor(part, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

cv::Mat depth_at_working_size(const cv::Mat& depth, cv::Size size) {
  if (depth.empty() || depth.size() == size) return depth;
  cv::Mat out(size, CV_16UC1);
  std::vector<std::uint16_t> valid;
  // The part of a side that a pixel covers; at least one pixel of it.
  const auto part = [](int i, int of, int length) {
    const auto begin = static_cast<int>(std::int64_t{i} * length / of);
    return std::pair(begin, std::max(begin + 1, static_cast<int>((std::int64_t{i} + 1) * length / of)));
  };
  for (int y = 0; y < size.height; ++y) {
    const auto [top, bottom] = part(y, size.height, depth.rows);
    for (int x = 0; x < size.width; ++x) {
      const auto [left, right] = part(x, size.width, depth.cols);
      valid.clear();
      for (int v = top; v < bottom; ++v) {
        const auto* row = depth.ptr<std::uint16_t>(v);
        std::copy_if(row + left, row + right, std::back_inserter(valid), [](std::uint16_t z) { return z != 0; });
      }
      const auto covered = std::size_t(bottom - top) * std::size_t(right - left);
      auto& z = out.ptr<std::uint16_t>(y)[x];
      z = 0;
      if (2 * valid.size() < covered) continue;
      const auto middle = valid.begin() + std::ptrdiff_t((valid.size() - 1) / 2);
      std::nth_element(valid.begin(), middle, valid.end());
      z = *middle;
    }
  }
  return out;
}

}  // namespace choreo::pipeline
