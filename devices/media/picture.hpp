// SPDX-License-Identifier: Apache-2.0
// From a decoded FFmpeg frame to an upright BGR picture with square pixels.
#pragma once

#include <cstdint>

#include <opencv2/core/mat.hpp>

#include "devices/media/libav.hpp"
#include "devices/oriented_source.hpp"

namespace choreo::devices {

/// How a display matrix hangs the picture.
struct Hanging {
  Orientation orientation;
  bool exact = true;  ///< False where the matrix asks for another angle than a multiple of 90 degrees.
};

/// The nearest of the eight orientations to a display matrix: p' = a p + c q, q' = b p + d q, with a, b, c, d at
/// positions 0, 1, 3, 4, p to the right and q down (libavutil/display.h). A matrix of zeros hangs nothing.
[[nodiscard]] Hanging hanging_of(const std::int32_t* matrix);

/// The size with square pixels: the height stays, the width follows the sample aspect ratio (0:1 is unknown, hence
/// square), rounded, at least 1.
[[nodiscard]] cv::Size with_square_pixels(cv::Size coded, AVRational sample_aspect);

/// Turns frames into pictures; keeps FFmpeg's conversion tables from one frame to the next.
///
/// Colour matrix and range are the frame's own. Unspecified, the matrix is BT.709 from 720 rows on and BT.601 below,
/// the range limited, except full for grey that no broadcast codec made.
class PictureMaker {
 public:
  /// @param filter  a SWS_ constant, how colours are enlarged between the rows that have them: SWS_BILINEAR takes them
  ///   from half a row beside, as quick as can be; SWS_BICUBIC does it as decoders of photographs do.
  explicit PictureMaker(AVCodecID codec, int filter = SWS_BILINEAR) : codec_(codec), filter_(filter) {}

  /// @return CV_8UC3, of its own memory.
  /// @throws Error (failure) where FFmpeg cannot convert the pixel format.
  [[nodiscard]] cv::Mat make(const AVFrame& frame, AVRational sample_aspect, const Orientation& orientation);

 private:
  void prepare(const AVFrame& frame);

  struct Key {
    int width = 0, height = 0, format = -1, colour_space = -1;
    bool full_range = false;
    bool operator==(const Key&) const = default;
  };

  AVCodecID codec_;
  int filter_;
  Key key_;
  bool limited_grey_ = false;
  Libav<SwsContext> context_;
  cv::Mat padded_;
};

}  // namespace choreo::devices
