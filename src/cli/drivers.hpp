// SPDX-License-Identifier: Apache-2.0
// Every driver of this build.
#pragma once

#include "core/time.hpp"
#include "devices/registry.hpp"

namespace choreo::cli {

/// @param clock  the host's monotonic clock, which outlives every source.
[[nodiscard]] devices::Registry all_drivers(const Clock& clock);

}  // namespace choreo::cli
