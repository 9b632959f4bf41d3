// SPDX-License-Identifier: Apache-2.0
// Pictures as PNG files, of any height: Cairo's end at 32767 rows.
#pragma once

#include <string>

#include <opencv2/core/mat.hpp>

namespace choreo::outputs {

/// @param picture  CV_8UC3, BGR, not empty.
/// @return the bytes of the file.
/// @throws Error (failure) where libpng cannot hold it.
[[nodiscard]] std::string png_of(const cv::Mat& picture);

}  // namespace choreo::outputs
