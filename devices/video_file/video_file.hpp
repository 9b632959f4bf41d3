// SPDX-License-Identifier: Apache-2.0
// The driver for video files: anything FFmpeg opens.
#pragma once

#include "devices/registry.hpp"

namespace choreo::devices {

/// Scheme "file".
///
/// Frames carry the file's own presentation times; they are upright (display matrix), of square pixels (sample aspect
/// ratio), in the colours the file declares. Frames the decoder calls damaged are left out. Neither pixels nor times
/// depend on the number of decoder threads.
[[nodiscard]] Driver video_file_driver();

/// A recording behind an address, such as http://host/clip.mp4: every frame as from a file, then the end.
/// @param patience  how long the peer may stay silent before that is a failure.
[[nodiscard]] std::unique_ptr<Source> open_remote_recording(const SourceUri& uri, const OpenOptions& options,
                                                            Nanoseconds patience);

}  // namespace choreo::devices
