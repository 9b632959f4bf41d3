// SPDX-License-Identifier: Apache-2.0
#include "devices/take/take_stream.hpp"

#include <algorithm>
#include <new>

#include <fmt/format.h>

#include "core/error.hpp"
#include "devices/fourcc.hpp"
#include "devices/take/plane_packing.hpp"

namespace choreo::devices::take {

TakeStream::TakeStream(const std::string& path, const AVCodecParameters& parameters, StreamFacts facts, int threads)
    : facts_(std::move(facts)) {
  const auto refuse = [&] {
    throw usage_error(fmt::format("\"{}\": {} in \"{}\" cannot be read", path, name_of(facts_.part),
                                  avcodec_get_name(parameters.codec_id)),
                      {}, "takes are FFV1, FFVHUFF or MJPEG");
  };
  if (facts_.fourcc == kMjpg) {
    if (parameters.codec_id != AV_CODEC_ID_MJPEG) refuse();
    return;
  }
  if (parameters.codec_id != AV_CODEC_ID_FFV1 && parameters.codec_id != AV_CODEC_ID_FFVHUFF) refuse();
  const auto* codec = avcodec_find_decoder(parameters.codec_id);
  if (codec == nullptr) refuse();
  decoder_.reset(avcodec_alloc_context3(codec));
  frame_.reset(av_frame_alloc());
  if (!decoder_ || !frame_) throw std::bad_alloc();
  if (avcodec_parameters_to_context(decoder_.get(), &parameters) < 0) refuse();
  // Threads over the slices of a picture: those over pictures would give the first one late.
  decoder_->thread_type = FF_THREAD_SLICE;
  decoder_->thread_count = std::max(threads, 0);
  decoder_->err_recognition = AV_EF_EXPLODE;
  decoder_->max_pixels = std::int64_t{16384} * 16384;
  if (avcodec_open2(decoder_.get(), codec, nullptr) < 0) refuse();
}

std::optional<std::vector<std::uint8_t>> TakeStream::bytes_of(const AVPacket& packet) {
  if (!decoder_) return std::vector<std::uint8_t>(packet.data, packet.data + packet.size);
  if (avcodec_send_packet(decoder_.get(), &packet) < 0) return std::nullopt;
  if (avcodec_receive_frame(decoder_.get(), frame_.get()) < 0) {
    avcodec_flush_buffers(decoder_.get());
    return std::nullopt;
  }
  const auto format = static_cast<AVPixelFormat>(frame_->format);
  const bool fits =
      frame_->width == facts_.size.width && frame_->height == facts_.size.height &&
      (format == planes_for(facts_.fourcc, AV_PIX_FMT_BGR0) || format == planes_for(facts_.fourcc, AV_PIX_FMT_GBRP));
  std::optional<std::vector<std::uint8_t>> bytes;
  if (fits && frame_->decode_error_flags == 0) bytes = from_planes(*frame_, facts_.fourcc);
  av_frame_unref(frame_.get());
  return bytes;
}

}  // namespace choreo::devices::take
