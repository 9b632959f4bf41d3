// SPDX-License-Identifier: Apache-2.0
// The synthetic performer by what stands behind synthetic://.
#pragma once

#include <string>

#include "devices/source_uri.hpp"
#include "devices/synthetic/performer.hpp"
#include "devices/synthetic/synthetic_source.hpp"

namespace choreo::test {

/// @param text  such as "walking?seed=5".
/// @throws Error (usage) as the driver does.
inline devices::synthetic::Performer performer_of(const std::string& text) {
  const auto request = devices::performer_request(
      devices::parse_source_uri("synthetic://" + text, [](const std::string&) { return false; }));
  return {request.script, request.settings};
}

}  // namespace choreo::test
