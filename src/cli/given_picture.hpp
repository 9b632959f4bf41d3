// SPDX-License-Identifier: Apache-2.0
// A picture that a person named on the command line.
#pragma once

#include <cstdint>
#include <string>

#include <opencv2/core/mat.hpp>

namespace choreo::cli {

/// Larger files are no picture: 256 MiB, which is 8K of three 16-bit channels, not compressed.
inline constexpr std::uintmax_t kMostPictureBytes = std::uintmax_t{256} << 20U;

/// Reads a whole picture: colour, 8 bit, whatever the file has.
/// @param what  it is, for messages: "mask".
/// @param hint  what would be right where it is none.
/// @return CV_8UC3, not empty.
/// @throws Error (usage) where the path is no regular file of at most `kMostPictureBytes` that holds a whole picture.
[[nodiscard]] cv::Mat read_picture(const std::string& path, const std::string& what, const std::string& hint);

}  // namespace choreo::cli
