// SPDX-License-Identifier: Apache-2.0
// All pictures of a set on one sheet, each with its name and the letter that was read of it.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include <opencv2/core/mat.hpp>

namespace choreo::outputs {

/// One picture on the sheet.
struct SheetTile {
  cv::Mat picture;     ///< CV_8UC3, of `size_on_sheet`.
  std::string name;    ///< Its file's, any bytes.
  std::string letter;  ///< Large; a dash where it is empty.
  std::string beside;  ///< Small: how sure that is, and the runner-up or the reason.
};

/// As large as a picture of that size stands on the sheet: 320 px wide, at most twice as high, where it is squeezed.
[[nodiscard]] cv::Size size_on_sheet(cv::Size picture);

/// The sheet: up to six pictures a row, in their order from the upper left on, each above its caption. Names that are
/// too long are shortened in their middle.
/// @return CV_8UC3; empty without tiles.
[[nodiscard]] cv::Mat picture_sheet(std::span<const SheetTile> tiles);

/// What the sheet and its tiles take of memory at most, in bytes.
[[nodiscard]] std::uint64_t bytes_of_sheet(std::uint64_t pictures);

}  // namespace choreo::outputs
