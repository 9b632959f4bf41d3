// SPDX-License-Identifier: Apache-2.0
// The driver for cameras of the Linux kernel: webcams, capture cards, virtual cameras.
#pragma once

#include "devices/registry.hpp"

namespace choreo::devices {

/// Scheme "v4l2": v4l2:///dev/video0?size=640x480&fps=60&format=YUYV, and any control by its v4l2-ctl name.
///
/// Frames come as they are made: where several wait, the newest is given and the numbers of the others are missing.
/// Times are the kernel's. A camera that vanishes is taken up again, with its mode and its controls, at the same port,
/// or at any where a link of /dev/v4l/by-id or a USB serial number names it.
[[nodiscard]] Driver v4l2_driver(const Clock& clock);

}  // namespace choreo::devices
