// SPDX-License-Identifier: Apache-2.0
// The driver for the first Kinect (models 1414, 1473, 1517) through libfreenect.
#pragma once

#include "devices/registry.hpp"

namespace choreo::devices {

/// Scheme "freenect": freenect://SERIAL?depth=registered&led=green&tilt=5; without a serial number the first there is.
///
/// Frames of 640 x 480 at 30 Hz: a colour and a depth picture at most half a frame apart by the Kinect's own clock, the
/// newest pair where several wait. One that vanishes is taken up again by its serial number, with its settings.
///
/// Settings: `depth` registered (onto the colour picture: by the device where it can, else as kinect_registered; the
/// default), raw (as the depth camera sees it; the default beside infrared) or off; `video` rgb or ir; `led` off,
/// green, red, yellow, blink-green or blink-red-yellow; `tilt` from -30 to 30 degrees upwards. What motor and LED of a
/// model cannot do is a warning. With `keep_raw` depth that the device has not registered comes with its words.
[[nodiscard]] Driver freenect_driver(const Clock& clock);

}  // namespace choreo::devices
