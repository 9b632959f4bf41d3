// SPDX-License-Identifier: Apache-2.0
#include "support/make_video.hpp"

#include <algorithm>
#include <cstring>
#include <memory>
#include <stdexcept>

extern "C" {
#include <libavformat/avformat.h>
#include <libavutil/log.h>
#include <libavutil/pixdesc.h>
}

namespace choreo::test {
namespace {

int must(int code, const char* what) {
  if (code >= 0) return code;
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(code, text, sizeof text);
  throw std::runtime_error(std::string(what) + ": " + text);
}

void write_packets(AVCodecContext& encoder, AVFormatContext& container, const AVFrame* frame, std::int64_t duration) {
  must(avcodec_send_frame(&encoder, frame), "avcodec_send_frame");
  const std::unique_ptr<AVPacket, void (*)(AVPacket*)> packet(av_packet_alloc(),
                                                              [](AVPacket* p) { av_packet_free(&p); });
  while (avcodec_receive_packet(&encoder, packet.get()) >= 0) {
    // Without a length the last frame would lie outside of an MP4's edit list.
    if (duration > 0) packet->duration = duration;
    if (packet->duration == 0)
      packet->duration = std::max<std::int64_t>(1, av_rescale_q(1, {1, 25}, encoder.time_base));
    av_packet_rescale_ts(packet.get(), encoder.time_base, container.streams[0]->time_base);
    must(av_interleaved_write_frame(&container, packet.get()), "av_interleaved_write_frame");
  }
}

}  // namespace

bool has_encoder(const char* name) { return avcodec_find_encoder_by_name(name) != nullptr; }

void fill_plane(AVFrame& frame, int plane, int value, bool words) {
  const auto* format = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
  const int shift = plane == 1 || plane == 2 ? format->log2_chroma_h : 0;
  const int rows = -((-frame.height) >> shift);
  for (int y = 0; y < rows; ++y) {
    auto* row = frame.data[plane] + std::ptrdiff_t{y} * frame.linesize[plane];
    for (int i = 0; i < frame.linesize[plane]; ++i) {
      row[i] = static_cast<std::uint8_t>(words ? (i % 2 == 0 ? value & 255 : value >> 8) : value);
    }
  }
}

void make_video(const std::string& path, const VideoRecipe& recipe) {
  av_log_set_level(AV_LOG_QUIET);
  AVFormatContext* made = nullptr;
  must(avformat_alloc_output_context2(&made, nullptr, recipe.format, path.c_str()), "avformat_alloc_output_context2");
  const std::unique_ptr<AVFormatContext, void (*)(AVFormatContext*)> container(made, [](AVFormatContext* c) {
    avio_closep(&c->pb);
    avformat_free_context(c);
  });
  const auto* codec = avcodec_find_encoder_by_name(recipe.encoder);
  if (codec == nullptr) throw std::runtime_error(std::string("no encoder ") + recipe.encoder);
  const std::unique_ptr<AVCodecContext, void (*)(AVCodecContext*)> encoder(
      avcodec_alloc_context3(codec), [](AVCodecContext* c) { avcodec_free_context(&c); });
  encoder->width = recipe.width;
  encoder->height = recipe.height;
  encoder->pix_fmt = recipe.pixel_format;
  encoder->time_base = recipe.time_base;
  encoder->sample_aspect_ratio = recipe.sample_aspect;
  encoder->colorspace = recipe.colour_space;
  encoder->color_range = recipe.colour_range;
  encoder->thread_count = recipe.threads;
  encoder->strict_std_compliance = FF_COMPLIANCE_UNOFFICIAL;
  if (codec->id == AV_CODEC_ID_FFV1) encoder->level = 3;
  encoder->flags |= AV_CODEC_FLAG_BITEXACT;
  if ((made->oformat->flags & AVFMT_GLOBALHEADER) != 0) encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  must(avcodec_open2(encoder.get(), codec, nullptr), "avcodec_open2");

  auto* stream = avformat_new_stream(made, nullptr);
  must(avcodec_parameters_from_context(stream->codecpar, encoder.get()), "avcodec_parameters_from_context");
  stream->time_base = encoder->time_base;
  stream->avg_frame_rate = recipe.rate;
  stream->sample_aspect_ratio = recipe.sample_aspect;
  if (recipe.display_matrix.size() == 9) {
    const std::size_t bytes = 9 * sizeof(std::int32_t);
    auto* side = av_stream_new_side_data(stream, AV_PKT_DATA_DISPLAYMATRIX, bytes);
    std::memcpy(side, recipe.display_matrix.data(), bytes);
  }
  made->flags |= AVFMT_FLAG_BITEXACT;
  must(avio_open(&made->pb, ("file:" + path).c_str(), AVIO_FLAG_WRITE), "avio_open");
  must(avformat_write_header(made, nullptr), "avformat_write_header");

  int index = 0;
  for (const auto time : recipe.times) {
    const std::unique_ptr<AVFrame, void (*)(AVFrame*)> frame(av_frame_alloc(), [](AVFrame* f) { av_frame_free(&f); });
    frame->width = recipe.width;
    frame->height = recipe.height;
    frame->format = recipe.pixel_format;
    frame->colorspace = recipe.colour_space;
    frame->color_range = recipe.colour_range;
    frame->pts = time;
    must(av_frame_get_buffer(frame.get(), 0), "av_frame_get_buffer");
    for (const auto* buffer : frame->buf) {
      if (buffer != nullptr) std::memset(buffer->data, 0, buffer->size);
    }
    recipe.paint(*frame, index++);
    write_packets(*encoder, *made, frame.get(), recipe.duration);
  }
  write_packets(*encoder, *made, nullptr, recipe.duration);
  must(av_write_trailer(made), "av_write_trailer");
}

}  // namespace choreo::test
