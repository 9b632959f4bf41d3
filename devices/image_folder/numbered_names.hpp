// SPDX-License-Identifier: Apache-2.0
// The order of numbered picture files: img2.png before img10.png.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace choreo::devices {

/// Whether the name is visible and ends in png, jpg, jpeg, bmp, tif, tiff, webp, pgm or ppm, in any case.
[[nodiscard]] bool is_picture_name(std::string_view name);

/// The names in the order of the one number that changes from name to name, whatever its digits: "a9_640x480.png"
/// comes before "a010_640x480.png".
/// @throws Error (usage) where the names differ in more than that, so that the order would be a guess, or where two
///   have the same number; it names examples.
[[nodiscard]] std::vector<std::string> in_number_order(const std::vector<std::string>& names, std::string_view folder);

/// The names of a set of pictures in the order of the alphabet, numbers within them by their value: A, b, B, c2, c10.
[[nodiscard]] std::vector<std::string> in_name_order(std::vector<std::string> names);

}  // namespace choreo::devices
