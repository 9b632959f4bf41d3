// SPDX-License-Identifier: Apache-2.0
// The bytes of a file that holds what was learned elsewhere.
#pragma once

#include <cstddef>
#include <string>

namespace choreo::pipeline {

/// @param most  bytes.  @param what  such as "a cascade".  @param hint  where it is to be had.
/// @throws Error (usage) where it is missing, no file, larger than that, or cannot be read.
[[nodiscard]] std::string bytes_of_model(const std::string& path, std::size_t most, const std::string& what,
                                         const std::string& hint);

/// @throws Error (usage) where it is missing or no file.
void require_model(const std::string& path, const std::string& hint);

}  // namespace choreo::pipeline
