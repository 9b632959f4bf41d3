// SPDX-License-Identifier: Apache-2.0
// One track of a take: from packets back to what the device gave.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "devices/media/libav.hpp"
#include "devices/take/take_format.hpp"

namespace choreo::devices::take {

/// Decodes packets, each of which stands alone.
/// @thread thread-bound
class TakeStream {
 public:
  /// @param path  of the file, for messages.
  /// @param threads  of the decoder; 0 lets it choose.
  /// @throws Error (usage) where the codec is none that a take has, or FFmpeg lacks it.
  TakeStream(const std::string& path, const AVCodecParameters& parameters, StreamFacts facts, int threads);

  [[nodiscard]] const StreamFacts& facts() const { return facts_; }

  /// The picture's bytes, lines without padding; of MJPG the packet. Nothing where the packet is damaged.
  [[nodiscard]] std::optional<std::vector<std::uint8_t>> bytes_of(const AVPacket& packet);

 private:
  StreamFacts facts_;
  Libav<AVCodecContext> decoder_;  // Null for MJPG.
  Libav<AVFrame> frame_;
};

}  // namespace choreo::devices::take
