// SPDX-License-Identifier: Apache-2.0
// Every driver of this build.
#pragma once

#include "devices/registry.hpp"

namespace choreo::cli {

[[nodiscard]] devices::Registry all_drivers();

}  // namespace choreo::cli
