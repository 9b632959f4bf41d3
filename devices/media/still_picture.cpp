// SPDX-License-Identifier: Apache-2.0
#include "devices/media/still_picture.hpp"

#include <algorithm>
#include <climits>
#include <cstring>
#include <string_view>

#include <opencv2/core.hpp>

extern "C" {
#include <libavutil/pixdesc.h>
}

#include "core/error.hpp"
#include "devices/media/libav.hpp"
#include "devices/media/picture.hpp"
#include "devices/media/picture_check.hpp"

namespace choreo::devices {
namespace {

struct Format {
  std::string_view begins;
  AVCodecID codec;
};

constexpr Format kFormats[] = {{"\x89PNG", AV_CODEC_ID_PNG},     {"\xff\xd8\xff", AV_CODEC_ID_MJPEG},
                               {"BM", AV_CODEC_ID_BMP},          {{"II*\0", 4}, AV_CODEC_ID_TIFF},
                               {{"MM\0*", 4}, AV_CODEC_ID_TIFF}, {"RIFF", AV_CODEC_ID_WEBP},
                               {"P1", AV_CODEC_ID_PBM},          {"P2", AV_CODEC_ID_PGM},
                               {"P3", AV_CODEC_ID_PPM},          {"P4", AV_CODEC_ID_PBM},
                               {"P5", AV_CODEC_ID_PGM},          {"P6", AV_CODEC_ID_PPM}};

AVCodecID codec_of(std::span<const std::uint8_t> file) {
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  const auto* found = std::ranges::find_if(kFormats, [&](const Format& f) { return text.starts_with(f.begins); });
  return found == std::end(kFormats) ? AV_CODEC_ID_NONE : found->codec;
}

// One decoded picture; nothing where the decoder finds fault with it.
Libav<AVFrame> decode(AVCodecID id, std::span<const std::uint8_t> file) {
  const auto* codec = avcodec_find_decoder(id);
  const Libav<AVCodecContext> decoder(avcodec_alloc_context3(codec));
  const Libav<AVPacket> packet(av_packet_alloc());
  Libav<AVFrame> frame(av_frame_alloc());
  if (codec == nullptr || !decoder || !packet || !frame) return {};
  if (avcodec_open2(decoder.get(), codec, nullptr) < 0) return {};
  if (av_new_packet(packet.get(), int(file.size())) < 0) return {};
  std::memcpy(packet->data, file.data(), file.size());
  forget_libav_message();
  if (avcodec_send_packet(decoder.get(), packet.get()) < 0) return {};
  (void)avcodec_send_packet(decoder.get(), nullptr);  // There is no second one to wait for.
  if (avcodec_receive_frame(decoder.get(), frame.get()) < 0) return {};
  // Of a TIFF whose rows end early FFmpeg says so and calls it a success.
  const bool damaged = (frame->flags & AV_FRAME_FLAG_CORRUPT) != 0 || frame->decode_error_flags != 0 ||
                       (id == AV_CODEC_ID_TIFF && !last_libav_message().empty());
  return damaged ? nullptr : std::move(frame);
}

Orientation orientation_of(const AVFrame& frame) {
  const auto* matrix = av_frame_get_side_data(&frame, AV_FRAME_DATA_DISPLAYMATRIX);
  if (matrix == nullptr || matrix->size < 9 * sizeof(std::int32_t)) return {};
  return hanging_of(reinterpret_cast<const std::int32_t*>(matrix->data)).orientation;
}

// 65535 becomes 255; swscale rounds half of the values up by one.
cv::Mat eight_of_sixteen_bits(const AVFrame& frame) {
  const Libav<SwsContext> context(sws_getContext(frame.width, frame.height, static_cast<AVPixelFormat>(frame.format),
                                                 frame.width, frame.height, AV_PIX_FMT_BGR48,
                                                 SWS_ACCURATE_RND | SWS_BITEXACT, nullptr, nullptr, nullptr));
  cv::Mat sixteen(frame.height, (frame.width + 63) / 32 * 32, CV_16UC3);  // Vector code may write past a row's end.
  std::uint8_t* planes[4] = {sixteen.data, nullptr, nullptr, nullptr};
  const int strides[4] = {int(sixteen.step[0]), 0, 0, 0};
  if (!context ||
      sws_scale(context.get(), frame.data, frame.linesize, 0, frame.height, planes, strides) != frame.height) {
    return {};
  }
  cv::Mat eight;
  sixteen.colRange(0, frame.width).convertTo(eight, CV_8U, 1.0 / 257.0);
  return eight;
}

bool has_sixteen_bits(const AVFrame& frame) {
  const auto* format = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
  return format != nullptr && format->comp[0].depth == 16 && (format->flags & AV_PIX_FMT_FLAG_FLOAT) == 0;
}

}  // namespace

cv::Mat decode_picture(std::span<const std::uint8_t> file) {
  const auto codec = codec_of(file);
  if (codec == AV_CODEC_ID_NONE || file.size() > INT_MAX / 2 || !is_whole_picture(file)) return {};
  silence_libav();
  const auto frame = decode(codec, file);
  if (!frame) return {};
  const auto orientation = orientation_of(*frame);
  try {
    if (has_sixteen_bits(*frame)) {
      const auto picture = eight_of_sixteen_bits(*frame);
      return picture.empty() ? picture : oriented(picture, orientation);
    }
    // Whatever a file says of its resolution, viewers show its pixels as squares.
    return PictureMaker(codec, SWS_BICUBIC).make(*frame, {1, 1}, orientation);
  } catch (const Error&) {
    return {};  // Pixels of a kind that no colour can be made of.
  } catch (const cv::Exception&) {
    return {};  // More of them than memory holds.
  }
}

}  // namespace choreo::devices
