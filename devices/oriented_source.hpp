// SPDX-License-Identifier: Apache-2.0
// Turns and flips the frames of another source.
#pragma once

#include <memory>

#include "devices/orientation.hpp"
#include "devices/source.hpp"

namespace choreo::devices {

/// The picture turned; a new picture unless the orientation is the identity.
[[nodiscard]] cv::Mat oriented(const cv::Mat& picture, const Orientation& orientation);

/// `source` with every frame turned.
[[nodiscard]] std::unique_ptr<Source> make_oriented(std::unique_ptr<Source> source, const Orientation& orientation);

}  // namespace choreo::devices
