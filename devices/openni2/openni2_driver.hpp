// SPDX-License-Identifier: Apache-2.0
// The driver for cameras and recordings of OpenNI2.
#pragma once

#include "devices/registry.hpp"

namespace choreo::devices {

/// Scheme "openni2": openni2://SERIAL, openni2://URI or openni2:// for any device, openni2:FILE.oni and plain paths of
/// such recordings.
///
/// Settings: video=any|rgb|ir|off (any is colour where there is one, else infrared, else a grey picture of the depth:
/// grey_of_depth in frame_maker.hpp), depth=on|off; of devices also size=WIDTHxHEIGHT, fps= and registration=on|off,
/// which brings depth onto colour where the device can. Depth and picture are paired by the device's own times.
///
/// Of a device the newest frame is given; one that vanishes is known again by its serial number, else by what it is. Of
/// a recording every frame is given once, as fast as it is read; its speed is the pipeline's matter (`pace`).
///
/// The library's own rules hold: it loads every lib*.so.0 of the folder OpenNI2/Drivers beside it, or of the folder
/// that /etc/openni2/OpenNI.ini names as [Drivers] Repository.
/// @param patience  how long OpenNI2 may stay silent before that is a failure.
[[nodiscard]] Driver openni2_driver(const Clock& clock, Nanoseconds patience = std::chrono::seconds(10));

}  // namespace choreo::devices
