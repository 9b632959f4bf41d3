// SPDX-License-Identifier: Apache-2.0
// What a frame is, wherever it comes from.
#pragma once

#include <cstdint>
#include <memory>

#include <opencv2/core/mat.hpp>

#include "core/time.hpp"

namespace choreo::devices {

/// One picture with its time. Filled by one writer, then published as `FramePtr` and never changed again.
struct Frame {
  /// Counts the source's frames from 0; a gap is a frame that was lost before it reached us.
  std::uint64_t sequence = 0;
  /// The source's own time stamp, strictly increasing within a source, of arbitrary origin.
  Nanoseconds device_time{0};
  /// CV_8UC3, blue green red; square pixels, upright, as a person would look at it.
  cv::Mat bgr;
};

using FramePtr = std::shared_ptr<const Frame>;

}  // namespace choreo::devices
