// SPDX-License-Identifier: Apache-2.0
#include "outputs/take_encoder.hpp"

#include <algorithm>
#include <cstring>
#include <new>
#include <thread>

#include <fmt/format.h>

extern "C" {
#include <libavutil/opt.h>
}

#include "core/error.hpp"
#include "core/text.hpp"
#include "devices/fourcc.hpp"
#include "devices/take/plane_packing.hpp"

namespace choreo::outputs {
namespace {

using devices::take::Part;

[[noreturn]] void give_up(Part part, int code) {
  throw failure(fmt::format("{} cannot be encoded: {}", devices::take::name_of(part), devices::libav_error_text(code)));
}

TakePicture picture_of(const devices::RawPicture& raw) {
  return {devices::dense_layout(raw.fourcc, raw.size), raw.bytes.data(), raw.bytes.size(), true};
}

TakePicture picture_of(const cv::Mat& picture, std::uint32_t fourcc) {
  if (picture.empty()) return {};
  return {{fourcc, picture.size(), picture.step[0]}, picture.data, 0, false};
}

}  // namespace

TakeCodec parse_take_codec(std::string_view text) {
  if (text == "auto") return TakeCodec::kAuto;
  if (text == "ffv1") return TakeCodec::kFfv1;
  if (text == "ffvhuff") return TakeCodec::kFfvhuff;
  throw usage_error(fmt::format("the codec \"{}\" is unknown", one_line(text)), {}, "known: auto, ffv1, ffvhuff");
}

TakePicture picture_of(const devices::Frame& frame, Part part) {
  if (part == Part::kColour) {
    return frame.raw_colour ? picture_of(*frame.raw_colour) : picture_of(frame.bgr, devices::kBgr3);
  }
  return frame.raw_depth ? picture_of(*frame.raw_depth) : picture_of(frame.depth, devices::kZ16);
}

TakeEncoder::TakeEncoder(Part part, const TakePicture& picture, const devices::SourceInfo& source, TakeCodec codec)
    : packet_(av_packet_alloc()) {
  if (!packet_) throw std::bad_alloc();
  facts_.part = part;
  facts_.fourcc = picture.layout.fourcc;
  facts_.raw = picture.raw;
  facts_.size = picture.layout.size;
  if (picture.raw) facts_.orientation = source.raw_orientation;
  facts_.registered = facts_.fourcc == devices::kKinectDepth && source.registers_depth;
  if (facts_.fourcc == devices::kMjpg) {
    facts_.codec = "mjpeg";
  } else {
    facts_.codec = codec == TakeCodec::kFfv1 ? "ffv1" : "ffvhuff";
    open(codec);
  }
}

void TakeEncoder::open(TakeCodec codec) {
  devices::silence_libav();
  const bool ffv1 = codec == TakeCodec::kFfv1;
  const auto* encoder = avcodec_find_encoder(ffv1 ? AV_CODEC_ID_FFV1 : AV_CODEC_ID_FFVHUFF);
  if (encoder == nullptr) throw failure(fmt::format("this FFmpeg cannot write {}", facts_.codec));
  encoder_.reset(avcodec_alloc_context3(encoder));
  frame_.reset(av_frame_alloc());
  if (!encoder_ || !frame_) throw std::bad_alloc();
  auto& e = *encoder_;
  e.width = facts_.size.width;
  e.height = facts_.size.height;
  e.pix_fmt = devices::take::planes_for(facts_.fourcc, ffv1 ? AV_PIX_FMT_BGR0 : AV_PIX_FMT_GBRP);
  if (e.pix_fmt == AV_PIX_FMT_NONE) {
    throw failure(fmt::format("\"{}\" is no format that a take can hold", devices::name_of_fourcc(facts_.fourcc)));
  }
  e.time_base = {1, 1000};
  e.sample_aspect_ratio = {1, 1};
  e.gop_size = 1;  // Every picture stands alone, so that damage does not spread.
  e.flags |= AV_CODEC_FLAG_BITEXACT | AV_CODEC_FLAG_GLOBAL_HEADER;
  e.thread_type = FF_THREAD_SLICE;
  const bool yuv = e.pix_fmt == AV_PIX_FMT_YUV422P || e.pix_fmt == AV_PIX_FMT_YUV420P;
  e.color_range = yuv ? AVCOL_RANGE_MPEG : AVCOL_RANGE_JPEG;
  if (yuv) e.colorspace = AVCOL_SPC_SMPTE170M;
  if (ffv1) {
    const int least = std::min(e.width, e.height) / (yuv ? 2 : 1);
    const bool large = e.width > 352 || e.height > 288;
    // FFmpeg's slices lose the pixels of planes that they cut one pixel wide or high; version 1 has none. One alone is
    // possible only up to 352x288 (ffv1enc.c).
    e.level = least < 8 ? 1 : 3;
    e.slices = least < 8 ? 0 : (!large && least < 64 ? 1 : (e.width * e.height > 1024 * 768 ? 16 : 4));
    if (e.level == 3) av_opt_set_int(e.priv_data, "slicecrc", 1, 0);
    const auto cores = static_cast<int>(std::thread::hardware_concurrency());
    e.thread_count = std::clamp(cores, 1, std::max(e.slices, 1));
  } else {
    e.thread_count = 1;
  }
  if (const int code = avcodec_open2(&e, encoder, nullptr); code < 0) give_up(facts_.part, code);
  frame_->format = e.pix_fmt;
  frame_->width = e.width;
  frame_->height = e.height;
  frame_->color_range = e.color_range;
  frame_->colorspace = e.colorspace;
  if (const int code = av_frame_get_buffer(frame_.get(), 0); code < 0) give_up(facts_.part, code);
  frame_->pts = 0;
}

void TakeEncoder::describe(AVCodecParameters& parameters) const {
  if (encoder_) {
    if (const int code = avcodec_parameters_from_context(&parameters, encoder_.get()); code < 0) {
      give_up(facts_.part, code);
    }
    return;
  }
  parameters.codec_type = AVMEDIA_TYPE_VIDEO;
  parameters.codec_id = AV_CODEC_ID_MJPEG;
  parameters.width = facts_.size.width;
  parameters.height = facts_.size.height;
}

AVPacket& TakeEncoder::encode(const TakePicture& picture) {
  const auto& layout = picture.layout;
  const bool fits = layout.fourcc == facts_.fourcc && layout.size == facts_.size && picture.raw == facts_.raw;
  if (!fits || (picture.raw && picture.size < std::max<std::size_t>(1, devices::bytes_of(layout)))) {
    throw failure(fmt::format("{} changes from {} {}x{} to {} {}x{}", devices::take::name_of(facts_.part),
                              devices::name_of_fourcc(facts_.fourcc), facts_.size.width, facts_.size.height,
                              devices::name_of_fourcc(layout.fourcc), layout.size.width, layout.size.height));
  }
  av_packet_unref(packet_.get());
  if (!encoder_) {
    if (picture.size > std::size_t{1} << 28U) throw failure("a JPEG picture is larger than 256 MB");
    if (av_new_packet(packet_.get(), static_cast<int>(picture.size)) < 0) throw std::bad_alloc();
    std::memcpy(packet_->data, picture.bytes, picture.size);
    packet_->flags |= AV_PKT_FLAG_KEY;
    return *packet_;
  }
  // The encoder may still hold the picture before.
  if (const int code = av_frame_make_writable(frame_.get()); code < 0) give_up(facts_.part, code);
  devices::take::to_planes(layout, picture.bytes, *frame_);
  int code = avcodec_send_frame(encoder_.get(), frame_.get());
  if (code >= 0) code = avcodec_receive_packet(encoder_.get(), packet_.get());
  if (code < 0) give_up(facts_.part, code);
  ++frame_->pts;
  return *packet_;
}

}  // namespace choreo::outputs
