// SPDX-License-Identifier: Apache-2.0
// The driver for a folder of pictures: a numbered sequence, or a set.
#pragma once

#include "devices/registry.hpp"

namespace choreo::devices {

/// Scheme "folder": png, jpg, jpeg, bmp, tif, tiff, webp, pgm and ppm files in the order of the one number that changes
/// from name to name; other and hidden files are not looked at. A photograph's own orientation (EXIF) is honoured, 16
/// bit become 8, grey becomes blue, green and red.
///
/// Where OpenOptions::sets allows it, a folder whose names do not count on in one number, or that holds one picture
/// alone, is a set of pictures: SourceInfo::stills, in the order of their names, of any sizes; so is a picture's file.
/// Setting `stills`: 1 makes a set of any folder, 0 of none.
///
/// Setting `fps`: pictures a second, 0.01 to 1000, default 30. Picture i, counted over all files in order, has the
/// time i / fps to the nearest nanosecond; fps counts in millionths.
[[nodiscard]] Driver image_folder_driver();

}  // namespace choreo::devices
