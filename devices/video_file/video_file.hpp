// SPDX-License-Identifier: Apache-2.0
// The driver for video files and network streams: anything FFmpeg opens.
#pragma once

#include "devices/registry.hpp"

namespace choreo::devices {

/// Scheme "file", and http, https, rtsp, rtmp, srt, udp, tcp, rtp.
///
/// Frames carry the file's own presentation times; they are upright (display matrix), of square pixels (sample aspect
/// ratio), in the colours the file declares. Frames the decoder calls damaged are left out. Neither pixels nor times
/// depend on the number of decoder threads.
/// @param patience  how long a network peer may stay silent before that is a failure.
[[nodiscard]] Driver video_file_driver(Nanoseconds patience = std::chrono::seconds(10));

}  // namespace choreo::devices
