// SPDX-License-Identifier: Apache-2.0
// What the helper does with OpenNI2.
#pragma once

#include "devices/openni2/helper_link.hpp"

namespace choreo::devices::openni2 {

/// Does what is asked for, until it is done or choreoscope hangs up. Never throws on the library's account: what goes
/// wrong is sent as Trouble.
void serve(const Request& request, HelperLink& link);

}  // namespace choreo::devices::openni2
