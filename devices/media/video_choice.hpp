// SPDX-License-Identifier: Apache-2.0
// Which track of a container is its video, and what is declared of it.
#pragma once

#include <string>
#include <vector>

#include "devices/media/libav.hpp"

namespace choreo::devices {

inline constexpr const char* kWhatIsAVideo = "give a video that FFmpeg can play, such as clip.mp4 or clip.mkv";

struct VideoChoice {
  AVStream* stream = nullptr;
  const AVCodec* codec = nullptr;  ///< That decodes it.
};

/// The default track, then the largest, then the first; a cover picture is no video. The others are discarded.
/// @param name  of the source, as messages say it.
/// @throws Error (usage) where there is none that FFmpeg can decode.
[[nodiscard]] VideoChoice choose_video(AVFormatContext& container, const std::string& name);

/// FFmpeg animates character art, and takes every text file for it.
/// @throws Error (usage) where that is what the container holds.
void refuse_character_art(const AVFormatContext& container, const std::string& name);

/// Tells declared frame rates from FFmpeg's guesses.
///
/// A tick of a clock is no frame rate. FFmpeg's avg_frame_rate is what the container's head says; else what the codec's
/// head or the lengths of the packets say; else, where a tick is longer than a millisecond, that a frame lasts one. Its
/// r_frame_rate is the coarsest tick that all time stamps fall on, as far as it has measured them, else what the
/// codec's head says, else the tick of the container (1000 in Matroska and FLV).
class DeclaredRates {
 public:
  DeclaredRates() = default;
  /// @param opened  a container of which no packet was looked at for anything that its head does not say.
  explicit DeclaredRates(const AVFormatContext& opened);

  /// Declared frame rate in Hz, after the packets were looked at; 0 where none is declared.
  [[nodiscard]] double fps(const AVStream& stream) const;

 private:
  std::vector<bool> in_head_;  // By stream.
  bool measures_ = true;       // FFmpeg looks at the time stamps of many packets.
};

}  // namespace choreo::devices
