// SPDX-License-Identifier: Apache-2.0
// From what OpenNI2 gives to what a frame holds.
#pragma once

#include <opencv2/core/mat.hpp>

#include "devices/frame.hpp"
#include "devices/media/raw_converter.hpp"
#include "devices/openni2/pairing.hpp"

namespace choreo::devices::openni2 {

/// The part of a frame that is pictures; as in Frame.
struct Pictures {
  cv::Mat bgr, depth;
  RawPicturePtr raw_colour, raw_depth;
};

/// Nearer than the first is white, farther than the second is black.
inline constexpr int kWhiteMm = 500, kBlackMm = 5000;

/// Depth as a picture: kWhiteMm to kBlackMm become 255 to 0; what is not known (0) is black.
/// @param depth  CV_16UC1, millimetres.  @return CV_8UC3, grey.
[[nodiscard]] cv::Mat grey_of_depth(const cv::Mat& depth);

/// @thread thread-bound
class FrameMaker {
 public:
  explicit FrameMaker(bool keep_raw) : keep_raw_(keep_raw) {}

  /// Colour or infrared as it is; of depth alone `grey_of_depth`. Depth of another size than the picture is brought to
  /// it, each pixel the nearest one.
  /// @throws Error (failure) on a damaged JPEG.
  [[nodiscard]] Pictures make(const Moment& moment);

 private:
  bool keep_raw_;
  RawConverter converter_;
};

}  // namespace choreo::devices::openni2
