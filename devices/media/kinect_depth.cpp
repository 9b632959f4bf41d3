// SPDX-License-Identifier: Apache-2.0
#include "devices/media/kinect_depth.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "core/error.hpp"

namespace choreo::devices {
namespace {

constexpr std::size_t kWords = 2048;
constexpr double kDepthFocal = 580;
constexpr double kColourFocal = 525;
constexpr double kBaselineMm = 25;

std::uint16_t converted(std::size_t word) {
  if (word == kNoKinectWord) return 0;
  const double shift_mm = ((static_cast<double>(word) - 4.0 * 200.0) / 4.0 - 0.375) * 0.1042;
  if (shift_mm >= 7.5) return 0;  // At infinity or behind it.
  const double mm = 10.0 * (shift_mm * 120.0 / (7.5 - shift_mm) + 120.0);
  return mm >= kNearestKinectMm && mm < kFarthestKinectMm + 1 ? static_cast<std::uint16_t>(mm) : 0;
}

const std::array<std::uint16_t, kWords>& table() {
  static const auto filled = [] {
    std::array<std::uint16_t, kWords> mm{};
    for (std::size_t word = 0; word < kWords; ++word) mm[word] = converted(word);
    return mm;
  }();
  return filled;
}

// Where a pixel lies in the colour picture, but for the parallax.
std::vector<double> scaled_places(int count) {
  const double centre = (count - 1) / 2.0;
  std::vector<double> places;
  for (int k = 0; k < count; ++k) places.push_back((k - centre) * kColourFocal / kDepthFocal + centre);
  return places;
}

// By how many pixels what is so far away moves to the left.
const std::vector<double>& parallaxes() {
  static const auto filled = [] {
    std::vector<double> px(kFarthestKinectMm + 1, 0.0);
    for (std::size_t mm = 1; mm < px.size(); ++mm) px[mm] = kColourFocal * kBaselineMm / static_cast<double>(mm);
    return px;
  }();
  return filled;
}

}  // namespace

std::uint16_t kinect_millimetres(std::uint16_t word) { return word < kWords ? table()[word] : 0; }

std::uint16_t kinect_word(std::uint16_t mm) {
  static const auto nearest = [] {
    std::vector<std::uint16_t> words(kFarthestKinectMm + 1, kNoKinectWord);
    // Distances never shrink as words grow: `above` is the first word at least so far away.
    const auto known = [](std::size_t word) { return table()[word] != 0; };
    std::size_t above = 0;
    while (!known(above)) ++above;
    for (int at = kNearestKinectMm; at <= kFarthestKinectMm; ++at) {
      while (known(above + 1) && table()[above] < at) ++above;
      const bool below = known(above - 1) && std::abs(table()[above - 1] - at) <= std::abs(table()[above] - at);
      words[static_cast<std::size_t>(at)] = static_cast<std::uint16_t>(below ? above - 1 : above);
    }
    return words;
  }();
  return mm < nearest.size() ? nearest[mm] : kNoKinectWord;
}

cv::Mat kinect_depth(std::span<const std::uint8_t> words, cv::Size size) {
  const auto pixels =
      static_cast<std::size_t>(std::max(0, size.width)) * static_cast<std::size_t>(std::max(0, size.height));
  if (pixels == 0 || words.size() != 2 * pixels) {
    throw failure(
        fmt::format("{} bytes are no depth picture of {}x{}, 16 bits each", words.size(), size.width, size.height));
  }
  cv::Mat mm(size, CV_16UC1);
  auto* out = mm.ptr<std::uint16_t>();
  const auto& known = table();
  for (std::size_t k = 0; k < pixels; ++k) {
    const auto word = static_cast<std::size_t>(words[2 * k] | words[2 * k + 1] << 8);
    out[k] = word < kWords ? known[word] : 0;
  }
  return mm;
}

cv::Mat kinect_registered(const cv::Mat& depth_mm) {
  if (depth_mm.size() != kKinectSize || depth_mm.type() != CV_16UC1) {
    throw failure(
        fmt::format("a depth picture has {}x{} pixels: only 640x480 of 16 bits can be brought onto the colour",
                    depth_mm.cols, depth_mm.rows));
  }
  static const auto columns = scaled_places(kKinectSize.width);
  static const auto lines = scaled_places(kKinectSize.height);
  const auto& parallax = parallaxes();
  cv::Mat out = cv::Mat::zeros(kKinectSize, CV_16UC1);
  for (int y = 0; y < depth_mm.rows; ++y) {
    const auto* from = depth_mm.ptr<std::uint16_t>(y);
    auto* to = out.ptr<std::uint16_t>(static_cast<int>(std::lround(lines[static_cast<std::size_t>(y)])));
    for (int x = 0; x < depth_mm.cols; ++x) {
      const auto mm = from[x];
      if (mm == 0 || mm > kFarthestKinectMm) continue;
      const double place = columns[static_cast<std::size_t>(x)] - parallax[mm];
      const int column = static_cast<int>(std::floor(place + 0.5));
      if (column < 0) continue;
      auto& there = to[column];
      if (there == 0 || mm < there) there = mm;
    }
  }
  return out;
}

}  // namespace choreo::devices
