// SPDX-License-Identifier: Apache-2.0
// How much memory there is, asked before a run takes it.
#pragma once

#include <cstdint>
#include <optional>

namespace choreo::cli {

/// What the system can give without swapping, in bytes (MemAvailable); nothing where it does not say.
[[nodiscard]] std::optional<std::uint64_t> available_memory();

}  // namespace choreo::cli
