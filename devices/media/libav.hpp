// SPDX-License-Identifier: Apache-2.0
// FFmpeg's C objects with owners, its error numbers as words, its times as nanoseconds.
#pragma once

#include <memory>
#include <optional>
#include <string>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavfilter/avfilter.h>
#include <libavformat/avformat.h>
#include <libswscale/swscale.h>
}

#include "core/time.hpp"

namespace choreo::devices {

struct LibavDeleter {
  void operator()(AVFilterGraph* p) const { avfilter_graph_free(&p); }
  void operator()(AVFormatContext* p) const { avformat_close_input(&p); }
  void operator()(AVCodecContext* p) const { avcodec_free_context(&p); }
  void operator()(AVFrame* p) const { av_frame_free(&p); }
  void operator()(AVPacket* p) const { av_packet_free(&p); }
  void operator()(SwsContext* p) const { sws_freeContext(p); }
};

template <typename T>
using Libav = std::unique_ptr<T, LibavDeleter>;

/// "Invalid data found when processing input" for AVERROR_INVALIDDATA, and so on.
[[nodiscard]] std::string libav_error_text(int code);

/// A count of time-base units as nanoseconds; nothing where it is missing (AV_NOPTS_VALUE) or beyond 100 years, which
/// only a damaged file says. The difference of any two fits as well.
[[nodiscard]] std::optional<Nanoseconds> libav_time(std::int64_t units, AVRational time_base);

/// Keeps FFmpeg from writing to stderr, for the whole process; what it would have said is kept for
/// `last_libav_message`. Calling it again does nothing.
void silence_libav();

/// The last error FFmpeg spoke of on this thread since `forget_libav_message`, one line of ASCII; may be empty.
[[nodiscard]] std::string last_libav_message();
void forget_libav_message();

}  // namespace choreo::devices
