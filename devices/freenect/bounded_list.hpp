// SPDX-License-Identifier: Apache-2.0
// A look at USB that is given up where the library does not come back from it.
#pragma once

#include <functional>

#include "core/time.hpp"
#include "devices/device_list.hpp"

namespace choreo::devices::freenect {

/// What `list` gives, called in a thread of its own; where that takes longer than `patience`, or it throws, a list
/// without devices that says so. The thread is then left to end by itself: `list` must own what it uses.
[[nodiscard]] DeviceList list_within(Nanoseconds patience, std::function<DeviceList()> list);

}  // namespace choreo::devices::freenect
