// SPDX-License-Identifier: Apache-2.0
// Which track of a container is its video, and what is declared of it.
#pragma once

#include <string>

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

/// Declared frame rate in Hz; 0 where none is declared.
[[nodiscard]] double declared_fps(const AVStream& stream);

}  // namespace choreo::devices
