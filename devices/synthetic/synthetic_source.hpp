// SPDX-License-Identifier: Apache-2.0
// The synthetic performer as a source of frames: synthetic://SCRIPT?size=640x480&seed=2
#pragma once

#include <string>

#include "devices/registry.hpp"
#include "devices/synthetic/performer.hpp"

namespace choreo::devices {

/// Which script to film, and how.
struct PerformerRequest {
  std::string script;
  synthetic::PerformerSettings settings;
};

/// Reads `SCRIPT?size=640x480&fps=30&seed=1&noise=3&drift=0&flicker=0&shake=0&depth=0&empty=1&tail=0&duration=10&
/// text=ABC&rate=12&build=auto&skin=auto&clothes=auto&sleeves=half&room=plain&light=neutral&poster=0&flags=0&distance=1&
/// place=0&pan=0:0:1&exposure=1`; what is left out has these values (duration: the script's own).
/// @param uri       with or without the scheme: only its location and settings are read.
/// @param settings  of that uri; what was already taken from it (rotate, flip) is not read again.
/// @throws Error (usage) for an unknown script or setting, or a value out of range.
[[nodiscard]] PerformerRequest performer_request(const SourceUri& uri, SettingReader& settings);
[[nodiscard]] PerformerRequest performer_request(const SourceUri& uri);

/// The driver for `synthetic://`.
[[nodiscard]] Driver synthetic_driver();

}  // namespace choreo::devices
