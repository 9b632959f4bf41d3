// SPDX-License-Identifier: Apache-2.0
// How far a library has read a file.
#pragma once

namespace choreo::devices::openni2 {

/// Whether this process has the file open a second time, and stands at its end there: OpenNI2 looks for ever for the
/// end of a recording that has none.
/// @param descriptor  of the file; stays where it is.
[[nodiscard]] bool stands_at_end(int descriptor);

}  // namespace choreo::devices::openni2
