// SPDX-License-Identifier: Apache-2.0
// A picture where a film is looked for.
#pragma once

#include "devices/source.hpp"

namespace choreo::cli {

/// What to do with pictures that show letters.
constexpr auto kHowPicturesAreRead =
    "the letter that a picture shows is read by choreoscope analyze PICTURE --recognise semaphore";

/// Whether the source is a picture's file, or a folder of one picture.
[[nodiscard]] bool is_one_picture(const devices::SourceInfo& source);

}  // namespace choreo::cli
