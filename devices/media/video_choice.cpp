// SPDX-License-Identifier: Apache-2.0
#include "devices/media/video_choice.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include "core/error.hpp"

namespace choreo::devices {

VideoChoice choose_video(AVFormatContext& container, const std::string& name) {
  const auto rank = [](const AVStream& s) {
    return std::pair((s.disposition & AV_DISPOSITION_DEFAULT) != 0,
                     std::int64_t{s.codecpar->width} * s.codecpar->height);
  };
  VideoChoice choice;
  std::string undecodable;
  for (unsigned i = 0; i < container.nb_streams; ++i) {
    auto* candidate = container.streams[i];
    candidate->discard = AVDISCARD_ALL;
    if (candidate->codecpar->codec_type != AVMEDIA_TYPE_VIDEO) continue;
    if ((candidate->disposition & AV_DISPOSITION_ATTACHED_PIC) != 0) continue;
    const auto* codec = avcodec_find_decoder(candidate->codecpar->codec_id);
    if (codec == nullptr) {
      undecodable = avcodec_get_name(candidate->codecpar->codec_id);
    } else if (choice.stream == nullptr || rank(*candidate) > rank(*choice.stream)) {
      choice = {candidate, codec};
    }
  }
  if (choice.stream == nullptr && !undecodable.empty()) {
    throw usage_error(fmt::format("\"{}\": FFmpeg cannot decode its video, \"{}\"", name, undecodable), {},
                      kWhatIsAVideo);
  }
  if (choice.stream == nullptr) {
    throw usage_error(fmt::format("\"{}\" has no video, only {} (format \"{}\")", name,
                                  container.nb_streams == 0 ? "empty tracks" : "sound, text or a cover picture",
                                  container.iformat->name),
                      {}, kWhatIsAVideo);
  }
  choice.stream->discard = AVDISCARD_DEFAULT;
  return choice;
}

void refuse_character_art(const AVFormatContext& container, const std::string& name) {
  static constexpr std::array kCodecs = {AV_CODEC_ID_ANSI, AV_CODEC_ID_BINTEXT, AV_CODEC_ID_XBIN, AV_CODEC_ID_IDF};
  for (unsigned i = 0; i < container.nb_streams; ++i) {
    if (std::find(kCodecs.begin(), kCodecs.end(), container.streams[i]->codecpar->codec_id) != kCodecs.end()) {
      throw usage_error(fmt::format("\"{}\" is text, not a video", name), {}, kWhatIsAVideo);
    }
  }
}

DeclaredRates::DeclaredRates(const AVFormatContext& opened) : measures_(opened.fps_probe_size != 0) {
  for (unsigned i = 0; i < opened.nb_streams; ++i) in_head_.push_back(opened.streams[i]->avg_frame_rate.num > 0);
}

double DeclaredRates::fps(const AVStream& stream) const {
  const auto tick = av_inv_q(stream.time_base);
  const auto is_rate = [](AVRational rate) {
    constexpr double kMost = 1000;  // Hz. Beyond, a codec's head declares its clock.
    return rate.num > 0 && rate.den > 0 && av_q2d(rate) <= kMost;
  };
  if (const auto rate = stream.avg_frame_rate; is_rate(rate)) {
    const auto index = static_cast<std::size_t>(stream.index);
    const bool in_head = index < in_head_.size() && in_head_[index];
    // Of a slower clock a tick is a frame, such as MXF's; of a faster one FFmpeg does not guess that.
    constexpr double kSlow = 300;
    constexpr double kFast = 1000;
    const bool guessed = !in_head && av_cmp_q(rate, tick) == 0 && av_q2d(tick) > kSlow && av_q2d(tick) < kFast;
    if (!guessed) return av_q2d(rate);
  }
  const auto rate = stream.r_frame_rate;
  return !measures_ && is_rate(rate) && av_cmp_q(rate, tick) != 0 ? av_q2d(rate) : 0;
}

}  // namespace choreo::devices
