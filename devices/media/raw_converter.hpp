// SPDX-License-Identifier: Apache-2.0
// From the pictures that devices give to BGR.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <opencv2/core/mat.hpp>

#include "devices/frame.hpp"
#include "devices/media/libav.hpp"
#include "devices/media/picture.hpp"

namespace choreo::devices {

/// How the bytes of a picture lie in memory.
struct Layout {
  std::uint32_t fourcc = 0;  ///< One of `known_formats()`.
  cv::Size size;
  std::size_t stride = 0;  ///< Bytes a line; 0 for MJPG.
};

/// The colour formats that can be turned into pictures, the ones that lose the least first.
[[nodiscard]] std::span<const std::uint32_t> known_formats();

/// Lines without padding. @param fourcc  one of `known_formats()`, or kZ16 or kKinectDepth.
[[nodiscard]] Layout dense_layout(std::uint32_t fourcc, cv::Size size);

/// How many bytes a whole picture has; 0 for MJPG, whose packets say themselves where they end.
[[nodiscard]] std::size_t bytes_of(const Layout& layout);

/// The picture with lines without padding, as a recording keeps it.
/// @param bytes  at least `bytes_of(layout)`; of MJPG the packet.
[[nodiscard]] RawPicturePtr keep_raw(const Layout& layout, std::span<const std::uint8_t> bytes);

/// Converts; keeps the decoder from one picture to the next.
/// @thread thread-bound
class RawConverter {
 public:
  /// @param bytes  at least `bytes_of(layout)`; of MJPG the packet.
  /// @return CV_8UC3, blue green red, of its own memory. YUV is BT.601 in limited range, as cameras send it.
  /// @throws Error (failure) on an unknown format, a size that the format cannot have, too few bytes, or a damaged
  /// JPEG.
  [[nodiscard]] cv::Mat to_bgr(const Layout& layout, std::span<const std::uint8_t> bytes);
  [[nodiscard]] cv::Mat to_bgr(const RawPicture& picture);

 private:
  [[nodiscard]] cv::Mat decode_jpeg(cv::Size size, std::span<const std::uint8_t> bytes);

  Libav<AVCodecContext> decoder_;
  Libav<AVPacket> packet_;
  Libav<AVFrame> frame_;
  PictureMaker maker_{AV_CODEC_ID_MJPEG};
};

}  // namespace choreo::devices
