// SPDX-License-Identifier: Apache-2.0
// Pictures that a Kinect could have seen, each one different, and dumps of them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "devices/media/kinect_depth.hpp"
#include "outputs/kinect_dump_writer.hpp"
#include "support/frames.hpp"

namespace choreo::test {

inline constexpr Nanoseconds kKinectPeriod{33'333'333};

inline cv::Mat kinect_colour(int k) {
  return noise(devices::kKinectSize, CV_8UC3, static_cast<std::uint64_t>(1000 + k));
}

/// Words of 11 bits of every kind, among them 2047.
inline std::vector<std::uint8_t> kinect_words(int k) {
  std::vector<std::uint8_t> words;
  const auto pixels = static_cast<std::uint32_t>(devices::kKinectSize.area());
  words.reserve(2 * pixels);
  for (std::uint32_t i = 0; i < pixels; ++i) {
    const auto word = (i * 7 + static_cast<std::uint32_t>(k) * 131 + i / 640) % 2048;
    words.push_back(static_cast<std::uint8_t>(word & 0xff));
    words.push_back(static_cast<std::uint8_t>(word >> 8));
  }
  return words;
}

/// A number that tells pictures apart (FNV-1a over the bytes); 0 of an empty one.
inline std::uint64_t fingerprint(const cv::Mat& picture) {
  if (picture.empty()) return 0;
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (int y = 0; y < picture.rows; ++y) {
    const auto* bytes = picture.ptr(y);
    for (std::size_t k = 0; k < picture.elemSize() * static_cast<std::size_t>(picture.cols); ++k) {
      hash = (hash ^ bytes[k]) * 0x100000001b3U;
    }
  }
  return hash;
}

/// Frame k has its colour at `begin` + k periods and its depth `depth_late` after it.
inline void write_kinect_dump(const std::string& folder, int frames, Nanoseconds begin = std::chrono::seconds(100),
                              Nanoseconds depth_late = std::chrono::milliseconds(4)) {
  outputs::KinectDumpWriter writer(folder);
  for (int k = 0; k < frames; ++k) {
    writer.write_colour(kinect_colour(k), begin + k * kKinectPeriod);
    writer.write_words(kinect_words(k), begin + k * kKinectPeriod + depth_late);
  }
}

}  // namespace choreo::test
