// SPDX-License-Identifier: Apache-2.0
// Labelled colours from a CSV: what tones are trained and tested on.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <opencv2/core/matx.hpp>

namespace choreo::config {

struct ColourTable {
  std::vector<cv::Vec3b> bgr;
  std::vector<int> label;  ///< One a colour.
};

/// One colour a line, separated by commas, semicolons, tabs or spaces; a first line may name the columns.
/// @param columns  what they are, such as "B,G,R,label", with "-" for what is not needed; empty: by the first line's
///   names (b or blue, ...; label, class or skin), or B,G,R,label where it has none.
/// @param name  stands in messages.
/// @throws Error (usage) with file:line for what is no whole number from 0 to 255, a label that is no whole number,
///   another number of columns, columns that are missing or there twice, or no colour at all.
[[nodiscard]] ColourTable parse_colour_table(std::string_view text, const std::string& name,
                                             const std::string& columns = {});

/// The same from a file of at most 256 MiB.
[[nodiscard]] ColourTable load_colour_table(const std::filesystem::path& path, const std::string& columns = {});

}  // namespace choreo::config
