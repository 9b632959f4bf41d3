// SPDX-License-Identifier: Apache-2.0
#include "devices/media/raw_converter.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "core/error.hpp"
#include "devices/fourcc.hpp"

namespace choreo::devices {
namespace {

std::size_t bytes_a_pixel(std::uint32_t fourcc) {
  switch (fourcc) {
    case kBgr3:
    case kRgb3:
      return 3;
    case kYuyv:
    case kUyvy:
    case kYvyu:
    case kZ16:
    case kKinectDepth:
      return 2;
    case kNv12:
    case kGrey:
      return 1;
    default:
      return 0;
  }
}

bool shares_colours_sideways(std::uint32_t fourcc) {
  return fourcc == kYuyv || fourcc == kUyvy || fourcc == kYvyu || fourcc == kNv12;
}

std::size_t lines_of(const Layout& layout) {
  const auto lines = std::size_t(layout.size.height);
  return layout.fourcc == kNv12 ? lines + (lines + 1) / 2 : lines;
}

}  // namespace

std::span<const std::uint32_t> known_formats() {
  static constexpr std::array<std::uint32_t, 8> kKnown = {kBgr3, kRgb3, kYuyv, kUyvy, kYvyu, kNv12, kMjpg, kGrey};
  return kKnown;
}

Layout dense_layout(std::uint32_t fourcc, cv::Size size) {
  return {fourcc, size, bytes_a_pixel(fourcc) * std::size_t(size.width)};
}

std::size_t bytes_of(const Layout& layout) { return layout.stride * lines_of(layout); }

RawPicturePtr keep_raw(const Layout& layout, std::span<const std::uint8_t> bytes) {
  auto raw = std::make_shared<RawPicture>();
  raw->fourcc = layout.fourcc;
  raw->size = layout.size;
  const auto line = dense_layout(layout.fourcc, layout.size).stride;
  if (line == layout.stride) {
    const auto whole = layout.fourcc == kMjpg ? bytes : bytes.first(bytes_of(layout));
    raw->bytes.assign(whole.begin(), whole.end());
    return raw;
  }
  raw->bytes.resize(line * lines_of(layout));
  for (std::size_t y = 0; y < lines_of(layout); ++y) {
    std::memcpy(raw->bytes.data() + y * line, bytes.data() + y * layout.stride, line);
  }
  return raw;
}

cv::Mat RawConverter::to_bgr(const RawPicture& picture) {
  return to_bgr(dense_layout(picture.fourcc, picture.size), picture.bytes);
}

cv::Mat RawConverter::to_bgr(const Layout& layout, std::span<const std::uint8_t> bytes) {
  const auto size = layout.size;
  if (layout.fourcc == kMjpg) return decode_jpeg(size, bytes);
  const auto line = dense_layout(layout.fourcc, size).stride;
  const bool possible = size.width > 0 && size.height > 0 && line > 0 && layout.stride >= line &&
                        bytes.size() >= bytes_of(layout) &&
                        !(shares_colours_sideways(layout.fourcc) && size.width % 2 != 0) &&
                        !(layout.fourcc == kNv12 && size.height % 2 != 0);
  if (!possible) {
    throw failure(fmt::format("{} bytes are no picture of {} {}x{}", bytes.size(), name_of_fourcc(layout.fourcc),
                              size.width, size.height));
  }
  auto* data = const_cast<std::uint8_t*>(bytes.data());
  const auto view = [&](int type) { return cv::Mat(size, type, data, layout.stride); };
  cv::Mat bgr;
  switch (layout.fourcc) {
    case kBgr3:
      return view(CV_8UC3).clone();
    case kRgb3:
      cv::cvtColor(view(CV_8UC3), bgr, cv::COLOR_RGB2BGR);
      return bgr;
    case kYuyv:
      cv::cvtColor(view(CV_8UC2), bgr, cv::COLOR_YUV2BGR_YUYV);
      return bgr;
    case kUyvy:
      cv::cvtColor(view(CV_8UC2), bgr, cv::COLOR_YUV2BGR_UYVY);
      return bgr;
    case kYvyu:
      cv::cvtColor(view(CV_8UC2), bgr, cv::COLOR_YUV2BGR_YVYU);
      return bgr;
    case kNv12: {
      const cv::Mat colours(size / 2, CV_8UC2, data + layout.stride * std::size_t(size.height), layout.stride);
      cv::cvtColorTwoPlane(view(CV_8UC1), colours, bgr, cv::COLOR_YUV2BGR_NV12);
      return bgr;
    }
    case kGrey:
      cv::cvtColor(view(CV_8UC1), bgr, cv::COLOR_GRAY2BGR);
      return bgr;
    default:
      throw failure(fmt::format("{} is no colour format", name_of_fourcc(layout.fourcc)));
  }
}

cv::Mat RawConverter::decode_jpeg(cv::Size size, std::span<const std::uint8_t> bytes) {
  const auto refuse = [&](int code) { throw failure("a JPEG picture is damaged: " + libav_error_text(code)); };
  if (!decoder_) {
    silence_libav();
    const auto* codec = avcodec_find_decoder(AV_CODEC_ID_MJPEG);
    if (codec == nullptr) throw failure("FFmpeg has no decoder for MJPG here");
    decoder_.reset(avcodec_alloc_context3(codec));
    packet_.reset(av_packet_alloc());
    frame_.reset(av_frame_alloc());
    if (!decoder_ || !packet_ || !frame_) throw failure("no memory to decode MJPG");
    decoder_->thread_count = 1;  // More would hold pictures back.
    decoder_->err_recognition = AV_EF_EXPLODE;
    if (const int code = avcodec_open2(decoder_.get(), codec, nullptr); code < 0) {
      decoder_.reset();
      refuse(code);
    }
  }
  // Copied: FFmpeg reads some bytes past the end.
  if (bytes.empty() || bytes.size() > std::size_t{1} << 28U) refuse(AVERROR_INVALIDDATA);
  if (const int code = av_new_packet(packet_.get(), static_cast<int>(bytes.size())); code < 0) refuse(code);
  std::memcpy(packet_->data, bytes.data(), bytes.size());
  int code = avcodec_send_packet(decoder_.get(), packet_.get());
  av_packet_unref(packet_.get());
  if (code >= 0) code = avcodec_receive_frame(decoder_.get(), frame_.get());
  if (code >= 0 && ((frame_->flags & AV_FRAME_FLAG_CORRUPT) != 0 || frame_->decode_error_flags != 0)) {
    code = AVERROR_INVALIDDATA;
  }
  if (code < 0) {
    avcodec_flush_buffers(decoder_.get());
    refuse(code);
  }
  if (frame_->width != size.width || frame_->height != size.height) {
    throw failure(fmt::format("a JPEG picture has {}x{} instead of {}x{} pixels", frame_->width, frame_->height,
                              size.width, size.height));
  }
  cv::Mat bgr = maker_.make(*frame_, AVRational{1, 1}, {});
  av_frame_unref(frame_.get());
  return bgr;
}

}  // namespace choreo::devices
