// SPDX-License-Identifier: Apache-2.0
// Whether a picture has any colour at all.
#pragma once

#include <opencv2/core/mat.hpp>

namespace choreo::vision {

/// Whether a picture is grey all over, as from an infrared or a black-and-white camera: fewer than one pixel in a
/// thousand has channels more than 8 grey levels apart, which is what decoders and lossy codecs make of grey.
/// @param picture  CV_8UC3. An empty one is colourless.
[[nodiscard]] bool colourless(const cv::Mat& picture);

}  // namespace choreo::vision
