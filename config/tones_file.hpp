// SPDX-License-Identifier: Apache-2.0
// Tones as text: what `choreoscope tones train` writes and runs read.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "vision/tone_model.hpp"

namespace choreo::config {

inline constexpr int kTonesVersion = 1;

/// Reads tones, in TOML as `print_tones` writes it.
/// @param name  stands in messages.
/// @throws Error (usage) with file:line:column for what is no tones file, part of one, of a later version, or wrong.
[[nodiscard]] vision::ToneSet parse_tones(std::string_view text, const std::string& name);

/// The same from a file of at most 4 MiB.
[[nodiscard]] vision::ToneSet load_tones(const std::filesystem::path& path);

/// Reads back as the same tones, to the last bit.
/// @param made_by  the command that made them; stands in a comment.
[[nodiscard]] std::string print_tones(const vision::ToneSet& tones, const std::string& made_by);

}  // namespace choreo::config
