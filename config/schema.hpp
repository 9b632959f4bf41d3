// SPDX-License-Identifier: Apache-2.0
// Each setting once: its key, kind, unit, range and meaning, and where its value lives.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <toml++/toml.h>

#include "config/options.hpp"

namespace choreo::config {

/// One setting.
struct Field {
  std::string key;    ///< "mask.threshold".
  std::string range;  ///< In words, with the unit: "above 0 and at most 255 grey levels, or \"auto\"".
  std::string help;   ///< What it does, one sentence.
  bool text = false;  ///< Whether a bare word on the command line is its value.
  /// Takes a value; false where its type or range is wrong, and nothing changes.
  std::function<bool(Options&, const toml::node&)> set;
  /// The value as TOML would have it.
  std::function<std::string(const Options&)> print;
};

/// All settings, in the order in which they are shown.
[[nodiscard]] const std::vector<Field>& schema();

}  // namespace choreo::config
