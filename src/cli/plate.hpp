// SPDX-License-Identifier: Apache-2.0
// A picture of the empty room, as the user gives it.
#pragma once

#include <string>

#include <opencv2/core/mat.hpp>

namespace choreo::cli {

/// Reads a plate: colour, 8 bit, whatever the file has.
/// @return CV_8UC3.
/// @throws Error (usage) where the path is no regular file of at most kMostPictureBytes that holds a whole picture.
[[nodiscard]] cv::Mat read_plate(const std::string& path);

}  // namespace choreo::cli
