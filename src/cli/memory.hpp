// SPDX-License-Identifier: Apache-2.0
// How much memory there is, asked before a run takes it.
#pragma once

#include <cstdint>
#include <optional>

namespace choreo::cli {

/// What may be taken without swapping, in bytes: what the system has (MemAvailable), and no more than what the
/// process's control group, such as a container, has left. Nothing where the system does not say.
[[nodiscard]] std::optional<std::uint64_t> available_memory();

}  // namespace choreo::cli
