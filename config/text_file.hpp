// SPDX-License-Identifier: Apache-2.0
// Reads a small file that a person named.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace choreo::config {

/// The bytes of a file of at most `most`.
/// @param what  it is, for messages: "tones file".
/// @throws Error (usage) where it is missing, a folder, unreadable or larger.
[[nodiscard]] std::string read_text_file(const std::filesystem::path& path, std::uintmax_t most,
                                         const std::string& what);

}  // namespace choreo::config
