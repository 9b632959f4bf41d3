// SPDX-License-Identifier: Apache-2.0
// The bytes of a picture file, decoded.
#pragma once

#include <cstdint>
#include <span>

#include <opencv2/core/mat.hpp>

namespace choreo::devices {

/// A PNG, JPEG, BMP, TIFF, WebP, PBM, PGM or PPM file as an upright picture; its first bytes tell which it is.
///
/// 16 bits become 8, grey is repeated, transparency is left out, and the orientation in a JPEG's EXIF is applied.
/// @return CV_8UC3; empty where the file is damaged, truncated, too large or no such picture.
[[nodiscard]] cv::Mat decode_picture(std::span<const std::uint8_t> file);

}  // namespace choreo::devices
