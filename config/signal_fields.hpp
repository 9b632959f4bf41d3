// SPDX-License-Identifier: Apache-2.0
// The settings of what leads from a picture to a letter: face, tones, arms, particles, semaphore.
#pragma once

#include <vector>

#include "config/schema.hpp"

namespace choreo::config {

/// Part of `schema()`.
[[nodiscard]] std::vector<Field> signal_fields();

}  // namespace choreo::config
