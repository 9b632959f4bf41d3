// SPDX-License-Identifier: Apache-2.0
// Makes one picture of frames whose odd and even lines were filmed at two moments.
#pragma once

#include "devices/media/libav.hpp"

namespace choreo::devices {

/// Whether a frame's even and odd lines are of two moments: it says so, or its moving edges are combs, one line wide
/// and five lines high at least. Untagged frames are looked at where their first plane has 8 bits.
[[nodiscard]] bool is_interlaced(const AVFrame& frame);

/// FFmpeg's bwdif: one frame out for one in, one frame later. What stands still keeps all its lines.
/// @thread thread-bound
class Deinterlacer {
 public:
  /// @param like  of the size and format of the frames to come.
  /// @throws Error (failure) where FFmpeg has no such filter for them.
  Deinterlacer(const AVFrame& like, AVRational time_base);

  [[nodiscard]] bool fits(const AVFrame& frame) const;
  /// Takes over what `frame` holds.  @throws Error (failure) where FFmpeg fails.
  void push(AVFrame& frame);
  void end();
  /// Fills `frame` with the next one. False where there is none yet, or no more behind `end`.
  [[nodiscard]] bool pull(AVFrame& frame);
  [[nodiscard]] bool ended() const { return ended_; }

 private:
  int width_, height_, format_;
  bool ended_ = false;
  Libav<AVFilterGraph> graph_;
  AVFilterContext* in_ = nullptr;
  AVFilterContext* out_ = nullptr;
};

}  // namespace choreo::devices
