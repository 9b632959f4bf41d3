// SPDX-License-Identifier: Apache-2.0
// One script for each motif of Z and Z*.
#include "devices/synthetic/moves.hpp"

namespace choreo::devices::synthetic {

std::vector<ScriptEntry> motif_scripts() { return {}; }

double semaphore_duration(const ScriptOptions&) { return 0; }

}  // namespace choreo::devices::synthetic
