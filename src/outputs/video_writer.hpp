// SPDX-License-Identifier: Apache-2.0
// Writes pictures with their times into a video file.
#pragma once

#include <memory>
#include <string>

#include <opencv2/core/mat.hpp>

#include "core/time.hpp"

namespace choreo::outputs {

enum class VideoCodec {
  kLossless,  ///< FFV1: every pixel comes back as it was. Version 3 with checksums, 1 below 4 pixels a side.
  kH264,      ///< libx264 at constant quality 18: small, plays everywhere.
  kMpeg4,     ///< MPEG-4 part 2: for where libx264 is missing.
};

enum class VideoContainer {
  kByEnding,  ///< Matroska for a name in .mkv, MP4 for one in .mp4.
  kMatroska,  ///< Whatever the name: for a temporary one.
  kMp4,
};

/// Pictures a second as a fraction, so that 30000/1001 is exact.
struct FrameRate {
  int numerator = 0;
  int denominator = 1;
};

struct VideoOptions {
  VideoCodec codec = VideoCodec::kLossless;
  VideoContainer container = VideoContainer::kByEnding;
  bool grey = false;  ///< One channel, kept as such where lossless: for masks.
  /// Declared in the file, and the length of the last picture; 0 declares none, and the last picture is as long as the
  /// one before. Times never rest on it.
  FrameRate rate{};
};

/// Whether this FFmpeg has the encoder.
[[nodiscard]] bool can_encode(VideoCodec codec);

/// The codec a file name asks for: .mkv is lossless, .mp4 is H.264, or MPEG-4 where libx264 is missing.
/// @throws Error (usage) for any other ending, or where the encoder is missing.
[[nodiscard]] VideoCodec video_codec_for(const std::string& path);

/// A video file being written. The same pictures and times give the same bytes on every run and any number of cores.
///
/// Everything goes to `path` + ".part", which `close` renames; without `close` it is deleted.
/// Lossy codecs halve the resolution of colour: an odd width or height is filled up by repeating the last column or
/// row.
class VideoWriter {
 public:
  /// @param path  ends in .mkv, or .mp4 for the lossy codecs, unless the options name the container.
  /// @param size  of every picture, in pixels, at least 1x1.
  /// @throws Error (usage) where the ending, the size or the place does not do, or the encoder is missing.
  VideoWriter(std::string path, cv::Size size, const VideoOptions& options = {});
  ~VideoWriter();
  VideoWriter(VideoWriter&&) noexcept;
  VideoWriter& operator=(VideoWriter&&) noexcept;

  /// Appends a picture.
  /// @param picture  CV_8UC3 (blue, green, red) or CV_8UC1, of the size declared; one channel only where `grey`.
  /// @param time     since the beginning of the file, not negative, later than the one before. Kept to 1 ms in
  ///                 Matroska and to 1/60000 s in MP4, and at least one such unit after the one before.
  /// @throws Error (failure) where the picture or time does not fit, or writing fails, as on a full disk.
  /// @cost   FFV1: about 20 ms a 640x480 colour picture on one core.
  void write(const cv::Mat& picture, Nanoseconds time);

  /// Finishes the file and gives it its name. Without it there is no file.
  /// @throws Error (failure) where anything could not be written.
  void close();

 private:
  class File;
  std::unique_ptr<File> file_;
};

}  // namespace choreo::outputs
