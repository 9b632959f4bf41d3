// SPDX-License-Identifier: Apache-2.0
// Encodes the pictures of one track of a take, each by itself and without loss.
#pragma once

#include <cstdint>
#include <string>

#include "devices/frame.hpp"
#include "devices/media/libav.hpp"
#include "devices/media/raw_converter.hpp"
#include "devices/source.hpp"
#include "devices/take/take_format.hpp"

namespace choreo::outputs {

enum class TakeCodec {
  kAuto,     ///< FFV1 where it keeps up, else FFVHUFF; measured on the first frame.
  kFfv1,     ///< Level 3 with slices and checksums: the smallest.
  kFfvhuff,  ///< About a tenth of the time and a fifth to a quarter more bytes.
};

/// "auto", "ffv1", "ffvhuff".
/// @throws Error (usage) otherwise.
[[nodiscard]] TakeCodec parse_take_codec(std::string_view text);

/// The bytes of a frame that go into one track.
struct TakePicture {
  devices::Layout layout;
  const std::uint8_t* bytes = nullptr;
  std::size_t size = 0;  ///< Of MJPG; else bytes_of(layout) may be read.
  bool raw = false;      ///< What the device gave, not what was made of it.
};

/// What of a frame is kept: the device's own picture where there is one. `bytes` is null where there is none.
[[nodiscard]] TakePicture picture_of(const devices::Frame& frame, devices::take::Part part);

/// @thread thread-bound
class TakeEncoder {
 public:
  /// @param picture  of the first frame; all others are of its layout.
  /// @param source   whose frame it is.
  /// @param codec    not kAuto. MJPG is stored as it is, whatever is said here.
  /// @throws Error (failure) where FFmpeg lacks the codec.
  TakeEncoder(devices::take::Part part, const TakePicture& picture, const devices::SourceInfo& source, TakeCodec codec);

  [[nodiscard]] const devices::take::StreamFacts& facts() const { return facts_; }
  void describe(AVCodecParameters& parameters) const;

  /// The packet, valid until the next call.
  /// @throws Error (failure) where the layout is another than the first picture's.
  [[nodiscard]] AVPacket& encode(const TakePicture& picture);

 private:
  void open(TakeCodec codec);

  devices::take::StreamFacts facts_;
  devices::Libav<AVCodecContext> encoder_;  // Null for MJPG.
  devices::Libav<AVFrame> frame_;
  devices::Libav<AVPacket> packet_;
};

}  // namespace choreo::outputs
