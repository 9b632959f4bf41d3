// SPDX-License-Identifier: Apache-2.0
// The driver for cameras on the network.
#pragma once

#include <functional>
#include <memory>

#include "devices/registry.hpp"

namespace choreo::devices {

/// Opens the recording behind an address; `patience` is how long its server may stay silent.
using OpenRemoteRecording =
    std::function<std::unique_ptr<Source>(const SourceUri&, const OpenOptions&, Nanoseconds patience)>;

/// Schemes rtsp, rtsps, http, https, rtmp, srt, udp, tcp, rtp: whatever FFmpeg opens there, such as multipart JPEG.
///
/// Settings: `patience` (seconds that opening may take, up to the first picture), `silence` (seconds without a picture
/// after which the camera is lost; more than its default for one that sends less than two a second), of rtsp
/// `transport=tcp|udp` and `listen=1` (wait for a sender to call).
///
/// A camera is decoded without pause by a thread of its own, and the newest picture is given; what it overtook is
/// missing in the numbers. Times are the sender's where the stream has them (RTP, MPEG), mapped by DeviceClock;
/// multipart JPEG has none: its pictures are stamped as they arrive. One that closes, breaks off or falls silent is
/// lost, and taken up again as soon as it answers.
///
/// What an http address gives is a recording where its container declares a duration, or the server the number of bytes
/// (MP4, Matroska; not of playlists and multipart JPEG): then it is opened by `recordings`, every frame is read, and
/// it ends.
[[nodiscard]] Driver network_driver(const Clock& clock, OpenRemoteRecording recordings);

}  // namespace choreo::devices
