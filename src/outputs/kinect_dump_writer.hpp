// SPDX-License-Identifier: Apache-2.0
// Writes what a first Kinect sees as a dump that libfreenect's fakenect plays and kinect-dump: reads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <opencv2/core/mat.hpp>

#include "core/time.hpp"

namespace choreo::outputs {

/// A folder of pictures and the list of them, INDEX.txt. A picture's line is appended once its file is whole: a dump
/// that was cut off is good up to there.
///
/// Times increase strictly within each stream and lie in the first 4e9 s of their clock; colour and depth of one
/// moment are paired by the reader where they are at most 16 ms apart. Names keep the nanosecond, and count the
/// device's ticks of 60 MHz from it.
/// @thread thread-bound
class KinectDumpWriter {
 public:
  /// Makes the folder where it is missing.
  /// @throws Error (usage) where it holds anything already or cannot be written to.
  explicit KinectDumpWriter(const std::filesystem::path& folder);
  ~KinectDumpWriter();
  KinectDumpWriter(const KinectDumpWriter&) = delete;
  KinectDumpWriter& operator=(const KinectDumpWriter&) = delete;

  /// @param bgr  CV_8UC3, 640 x 480.
  /// @throws Error (failure) on another size or type, a time that does not increase, or a disk that is full; as the
  ///   other two.
  void write_colour(const cv::Mat& bgr, Nanoseconds time);
  /// @param depth_mm  CV_16UC1, 640 x 480, millimetres, 0 where nothing is known; written as the nearest words of 11
  ///   bits (devices/media/kinect_depth.hpp). A reader takes it for the depth camera's own view: what lies on the
  ///   colour picture already is to be read with depth=raw.
  void write_depth(const cv::Mat& depth_mm, Nanoseconds time);
  /// @param words  640 x 480 words of 11 bits as the device gave them, 16 bits each, the low byte first.
  void write_words(std::span<const std::uint8_t> words, Nanoseconds time);

 private:
  struct Stream {
    char kind;
    std::string_view extension;
    std::string_view header;
    std::optional<Nanoseconds> last = std::nullopt;
  };
  void write(Stream& stream, std::span<const std::uint8_t> pixels, Nanoseconds time);

  std::filesystem::path folder_;
  int index_ = -1;
  Stream colour_;
  Stream depth_;
};

}  // namespace choreo::outputs
