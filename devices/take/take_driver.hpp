// SPDX-License-Identifier: Apache-2.0
// The driver for takes: what choreoscope recorded, frame for frame as it came.
#pragma once

#include "devices/registry.hpp"

namespace choreo::devices {

/// Scheme "take", and every file that says it is a take, whatever its name.
///
/// Frames carry the sequence numbers and times they had; their pictures are made of the recorded bytes as the device's
/// driver made them. Damaged frames are left out, and a recording that was cut off ends where it was: the warnings say
/// so. A take of depth alone gives black pictures.
///
/// Settings: `frames=all`, or `frames=processed` for those that the run which recorded it processed; the others are
/// then Frame::overtaken, so that the same settings give the same results.
[[nodiscard]] Driver take_driver();

}  // namespace choreo::devices
