// SPDX-License-Identifier: Apache-2.0
// The driver for dumps of the first Kinect, as libfreenect's fakenect-record writes them.
#pragma once

#include "devices/registry.hpp"

namespace choreo::devices {

/// Scheme "kinect-dump": a folder with INDEX.txt and the pictures it names, read without the library.
///
/// A frame is a colour picture and the depth picture nearest in time, at most half a frame's time away; those without
/// such a partner, and pictures that cannot be read, are left out, and a warning counts them. Where the index has no
/// depth at all, frames have none. Times are those of the names.
///
/// Setting `depth`: registered (onto the colour picture, as kinect_registered; the default), raw (as the depth camera
/// sees it) or off. With `keep_raw` frames carry the depth words.
[[nodiscard]] Driver kinect_dump_driver();

}  // namespace choreo::devices
