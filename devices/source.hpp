// SPDX-License-Identifier: Apache-2.0
// What a source of frames is.
#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "devices/frame.hpp"
#include "devices/orientation.hpp"

namespace choreo::devices {

/// What is known of a source before its frames are read.
struct SourceInfo {
  std::string name;                     ///< As the user wrote it.
  cv::Size size;                        ///< Of every frame as delivered, in pixels.
  double nominal_fps = 0;               ///< Declared rate in Hz; 0 where none is declared. Times never rest on it.
  std::optional<Nanoseconds> duration;  ///< Declared length; files lie about it.
  bool live = false;                    ///< A device: what nobody takes in time is gone.
  bool repeatable = true;               ///< Opening the same SOURCE again gives the same frames (a file, not a pipe).
  /// Its later frames may be looked at before its first ones are analysed. Not where a take stands for the device it
  /// was recorded from.
  bool foreseeable = true;
  /// A set of pictures without an order in time, each a frame of its own size; `size` is the first's.
  bool stills = false;
  /// Pictures in files of their own, taken for the frames of a video for no other reason than that their names
  /// count on.
  bool numbered_pictures = false;
  bool depth = false;            ///< Its frames have Frame::depth, all but a few.
  Orientation raw_orientation;   ///< What was done to Frame::raw_colour and raw_depth to hang them upright.
  bool registers_depth = false;  ///< Frame::depth is Frame::raw_depth brought onto the colour (media/kinect_depth.hpp).
  std::string controls;          ///< What a device was set to as it was opened: "gain=3&exposure=120"; else empty.
  std::string settings;          ///< Of the run that recorded a take, where it stands for that run; else empty.
};

/// Gives frames in order, one caller at a time.
///
/// Destroying a source stops it.
/// @thread thread-bound
class Source {
 public:
  virtual ~Source() = default;
  Source() = default;
  Source(const Source&) = delete;
  Source& operator=(const Source&) = delete;

  [[nodiscard]] virtual const SourceInfo& info() const = 0;

  /// The next frame; null at the end, or when `stop` was requested while waiting.
  /// @throws Error (failure) where the source breaks in a way that later frames cannot mend, such as a frame size
  ///   that changes midway. A damaged or truncated recording is no error: the good frames come, then the end, and
  ///   `warnings` says so.
  virtual FramePtr read(std::stop_token stop) = 0;

  /// As `read`, for those who need no picture of this frame: `bgr` may be empty where making it takes time.
  virtual FramePtr skim(std::stop_token stop) { return read(std::move(stop)); }

  /// One line for each thing that was not as it should be, so far.
  [[nodiscard]] virtual std::vector<std::string> warnings() const { return {}; }
};

}  // namespace choreo::devices
