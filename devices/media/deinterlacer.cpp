// SPDX-License-Identifier: Apache-2.0
#include "devices/media/deinterlacer.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <string>
#include <utility>

#include <fmt/format.h>

extern "C" {
#include <libavfilter/avfilter.h>
#include <libavfilter/buffersink.h>
#include <libavfilter/buffersrc.h>
#include <libavutil/frame.h>
#include <libavutil/pixdesc.h>
}

#include "core/error.hpp"

namespace choreo::devices {
namespace {

constexpr int kEvery = 5;  // Lines: all would take as long as some decoders, and an odd number meets either field.

// Places on these lines of an 8-bit plane that changed and where five values in a row, `step` bytes apart, alternate
// between two that are far apart.
std::int64_t combs(const AVFrame& frame, const AVFrame& last, std::ptrdiff_t step, std::ptrdiff_t last_step) {
  constexpr int kAlike = 10, kApart = 20;  // Grey levels.
  std::int64_t count = 0;
  for (int y = 2; y + 2 < frame.height; y += kEvery) {
    const auto* line = frame.data[0] + std::ptrdiff_t{y} * frame.linesize[0];
    const auto* before = last.data[0] + std::ptrdiff_t{y} * last.linesize[0];
    for (int x = 2; x + 2 < frame.width; ++x) {
      const auto at = [&](int k) { return int(line[x + k * step]); };
      if (std::abs(at(0) - at(1)) <= kApart) continue;
      const bool alternates =
          std::abs(at(0) - at(2)) < kAlike && std::abs(at(0) - at(-2)) < kAlike && std::abs(at(1) - at(-1)) < kAlike;
      // Of an edge that moves one field at least shows something else now.
      const bool changed = std::abs(at(0) - before[x]) > kApart || std::abs(at(1) - before[x + last_step]) > kApart;
      count += alternates && changed ? 1 : 0;
    }
  }
  return count;
}

bool can_be_looked_at(const AVFrame& frame) {
  const auto* description = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
  return description != nullptr && (description->flags & (AV_PIX_FMT_FLAG_HWACCEL | AV_PIX_FMT_FLAG_RGB)) == 0 &&
         description->comp[0].depth == 8 && description->comp[0].step == 1;
}

}  // namespace

bool Interlacing::is_seen_in(const AVFrame& frame) {
  constexpr int kLeastSide = 16;  // The filter refuses what has hardly a line.
  if (std::min(frame.width, frame.height) < kLeastSide) return false;
  if (frame.interlaced_frame != 0) return true;
  const auto last = std::exchange(last_, Libav<AVFrame>(av_frame_clone(&frame)));
  if (!last || last->width != frame.width || last->height != frame.height || last->format != frame.format ||
      !can_be_looked_at(frame)) {
    return false;
  }
  // Noise and fine patterns are as much so from left to right.
  constexpr double kShare = 0.0005;
  constexpr double kLeast = 20;  // Places; in a small picture chance makes one or two.
  const double least = std::max(kLeast, kShare * frame.width * frame.height / kEvery);
  const auto down = double(combs(frame, *last, frame.linesize[0], last->linesize[0]));
  return down > least && down > least + 4 * double(combs(frame, *last, 1, 1));
}

Deinterlacer::Deinterlacer(const AVFrame& like, AVRational time_base)
    : width_(like.width), height_(like.height), format_(like.format), graph_(avfilter_graph_alloc()) {
  if (!graph_) throw std::bad_alloc();
  graph_->nb_threads = 1;
  const auto make = [&](const char* filter, const std::string& arguments) {
    AVFilterContext* made = nullptr;
    const int code =
        avfilter_graph_create_filter(&made, avfilter_get_by_name(filter), filter,
                                     arguments.empty() ? nullptr : arguments.c_str(), nullptr, graph_.get());
    if (code < 0) throw failure(fmt::format("FFmpeg's filter {}: {}", filter, libav_error_text(code)));
    return made;
  };
  in_ = make("buffer", fmt::format("video_size={}x{}:pix_fmt={}:time_base={}/{}", width_, height_, format_,
                                   time_base.num, time_base.den));
  auto* filter = make("bwdif", "mode=send_frame:deint=all");
  out_ = make("buffersink", {});
  int code = avfilter_link(in_, 0, filter, 0);
  if (code >= 0) code = avfilter_link(filter, 0, out_, 0);
  if (code >= 0) code = avfilter_graph_config(graph_.get(), nullptr);
  if (code < 0) throw failure(fmt::format("FFmpeg cannot deinterlace: {}", libav_error_text(code)));
}

bool Deinterlacer::fits(const AVFrame& frame) const {
  return frame.width == width_ && frame.height == height_ && frame.format == format_;
}

void Deinterlacer::push(AVFrame& frame) {
  frame.pts = frame.best_effort_timestamp;
  const int code = av_buffersrc_add_frame(in_, &frame);
  if (code == AVERROR(ENOMEM)) throw std::bad_alloc();
  if (code < 0) throw failure(fmt::format("FFmpeg cannot deinterlace: {}", libav_error_text(code)));
}

void Deinterlacer::end() {
  ended_ = true;
  const int code = av_buffersrc_add_frame(in_, nullptr);
  if (code < 0) throw failure(fmt::format("FFmpeg cannot deinterlace: {}", libav_error_text(code)));
}

bool Deinterlacer::pull(AVFrame& frame) {
  const int code = av_buffersink_get_frame(out_, &frame);
  if (code == AVERROR(ENOMEM)) throw std::bad_alloc();
  if (code < 0 && code != AVERROR(EAGAIN) && code != AVERROR_EOF) {
    throw failure(fmt::format("FFmpeg cannot deinterlace: {}", libav_error_text(code)));
  }
  return code >= 0;
}

}  // namespace choreo::devices
