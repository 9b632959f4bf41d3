// SPDX-License-Identifier: Apache-2.0
// Notices that one of a device's streams has fallen silent while the other goes on.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/time.hpp"
#include "devices/device_source.hpp"
#include "devices/openni2/protocol.hpp"

namespace choreo::devices::openni2 {

/// "colour", "infrared" or "depth".
[[nodiscard]] std::string name_of(Sensor sensor);

/// DeviceSource sees frames, and frames go on when depth alone has stopped: this asks of each stream, by what is heard
/// of the other, what it asks of the whole. Where all are silent it says nothing: that is DeviceSource's to tell.
/// @thread thread-bound
class StreamWatch {
 public:
  /// @param limits  as DeviceSource has them, each of a stream: first_frame for its first picture, then silent_frames
  ///   between least_silence and most_silence.
  StreamWatch(const std::vector<Mode>& streams, Nanoseconds now, const DeviceOptions& limits = {});

  /// Somebody begins to listen: what came not before, nobody would have heard.
  void begin(Nanoseconds now);
  /// Of the stream came so many pictures in all, as is known `now`.
  void heard(std::size_t stream, std::uint64_t pictures, Nanoseconds now);
  /// Nobody listens any more.
  /// @throws DeviceLost where a stream has been silent for too long while another was heard.
  void end(Nanoseconds now);

  /// Whether each stream has given a picture.
  [[nodiscard]] bool complete() const;

 private:
  struct Stream {
    Mode mode;
    std::uint64_t pictures = 0;
    Nanoseconds last_heard{0};
  };
  [[nodiscard]] Nanoseconds longest_silence(const Stream& stream) const;

  DeviceOptions limits_;
  std::vector<Stream> streams_;
  std::optional<Nanoseconds> left_at_;
};

}  // namespace choreo::devices::openni2
