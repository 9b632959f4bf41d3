// SPDX-License-Identifier: Apache-2.0
// Reads a whole source, and says of pictures and errors what tests ask.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "core/error.hpp"
#include "devices/registry.hpp"

namespace choreo::test {

inline std::vector<devices::FramePtr> all_frames(devices::Source& source) {
  std::vector<devices::FramePtr> frames;
  while (auto frame = source.read({})) frames.push_back(std::move(frame));
  return frames;
}

inline bool same_pixels(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

/// What `action` throws; nothing where it throws nothing.
template <typename Action>
std::optional<Error> error_of(Action action) {
  try {
    action();
  } catch (const Error& error) {
    return error;
  }
  return std::nullopt;
}

/// A picture of noise, the same for the same seed.
inline cv::Mat noise(cv::Size size, int type, std::uint64_t seed) {
  cv::Mat picture(size, type);
  cv::RNG random(seed);
  random.fill(picture, cv::RNG::UNIFORM, 0, 256);
  return picture;
}

}  // namespace choreo::test
