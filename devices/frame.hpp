// SPDX-License-Identifier: Apache-2.0
// What a frame is, wherever it comes from.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/time.hpp"

namespace choreo::devices {

/// A picture as the device gave it, before anything was converted: what a recording keeps.
struct RawPicture {
  std::uint32_t fourcc = 0;  ///< devices/fourcc.hpp
  cv::Size size;
  /// Lines without padding; of NV12 the luma, then the colours; of MJPG the packet.
  std::vector<std::uint8_t> bytes;
};
using RawPicturePtr = std::shared_ptr<const RawPicture>;

/// One picture with its time. Filled by one writer, then published as `FramePtr` and never changed again.
struct Frame {
  /// Counts the source's frames from 0; a gap is a frame that was lost before it reached us.
  std::uint64_t sequence = 0;
  /// The source's own time stamp, strictly increasing within a source, of arbitrary origin; a device's is on the host's
  /// monotonic clock.
  Nanoseconds device_time{0};
  /// CV_8UC3, blue green red; square pixels, upright, as a person would look at it.
  cv::Mat bgr;
  /// CV_16UC1, millimetres from the camera's plane, 0 where nothing is known; of the size of `bgr`, pixel on pixel
  /// where the source registers them. Empty where the source has none.
  cv::Mat depth;
  /// What `bgr` was made of, upright or not; null where `bgr` has every byte of it, or where nobody asked for it
  /// (OpenOptions::keep_raw).
  RawPicturePtr raw_colour;
  /// Likewise what `depth` was made of.
  RawPicturePtr raw_depth;
  /// Of a take that is replayed as it was processed: the run that recorded it never came to this frame. It is counted
  /// and may teach the background, and goes no further.
  bool overtaken = false;
  /// Likewise: a detection of faces that was due at this frame was not ready in that run, and had no effect.
  bool late_face = false;
  bool late_person = false;  ///< Likewise a look for people.
  std::string name;  ///< Of the file that holds this picture alone; empty of videos and devices.
};

using FramePtr = std::shared_ptr<const Frame>;

}  // namespace choreo::devices
