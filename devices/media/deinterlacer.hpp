// SPDX-License-Identifier: Apache-2.0
// Makes one picture of frames whose odd and even lines were filmed at two moments.
#pragma once

#include "devices/media/libav.hpp"

namespace choreo::devices {

/// Finds out whether even and odd lines are of two moments.
///
/// A frame says so, or what changed in it since the frame before has edges like combs, of lines one by one, five lines
/// high at least. Frames that say nothing are looked at where their first plane has 8 bits.
/// @thread thread-bound
class Interlacing {
 public:
  /// @param frame  each in turn, of any size and format; kept until the next one comes.
  [[nodiscard]] bool is_seen_in(const AVFrame& frame);

 private:
  Libav<AVFrame> last_;
};

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
  /// @throws Error (failure) where FFmpeg fails.
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
