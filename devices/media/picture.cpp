// SPDX-License-Identifier: Apache-2.0
#include "devices/media/picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

extern "C" {
#include <libavutil/pixdesc.h>
}

#include "core/error.hpp"

namespace choreo::devices {
namespace {

bool is_grey(const AVPixFmtDescriptor& format) {
  return (format.flags & (AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL | AV_PIX_FMT_FLAG_BITSTREAM)) == 0 &&
         format.nb_components <= 2;
}

// Video codecs of broadcasting mean limited range when they say nothing, also in grey.
bool is_broadcast(AVCodecID codec) {
  static constexpr std::array kCodecs = {AV_CODEC_ID_H264, AV_CODEC_ID_HEVC, AV_CODEC_ID_AV1, AV_CODEC_ID_VP9,
                                         AV_CODEC_ID_MPEG2VIDEO};
  return std::find(kCodecs.begin(), kCodecs.end(), codec) != kCodecs.end();
}

bool is_full_range(const AVFrame& frame, const AVPixFmtDescriptor& format, AVCodecID codec) {
  switch (frame.format) {
    case AV_PIX_FMT_YUVJ411P:
    case AV_PIX_FMT_YUVJ420P:
    case AV_PIX_FMT_YUVJ422P:
    case AV_PIX_FMT_YUVJ440P:
    case AV_PIX_FMT_YUVJ444P:
      return true;
    default:
      break;
  }
  if (frame.color_range != AVCOL_RANGE_UNSPECIFIED) return frame.color_range == AVCOL_RANGE_JPEG;
  return is_grey(format) && !is_broadcast(codec);
}

// Black at 16 and white at 235 become 0 and 255. swscale takes all grey for full range, whatever it is told.
void widen_range(cv::Mat& picture) {
  static const cv::Mat kTable = [] {
    cv::Mat table(1, 256, CV_8UC1);
    for (int i = 0; i < 256; ++i)
      table.at<std::uint8_t>(0, i) = cv::saturate_cast<std::uint8_t>((i - 16) * 255.0 / 219);
    return table;
  }();
  cv::LUT(picture, kTable, picture);
}

// The index of FFmpeg's table of coefficients.
int colour_space_of(const AVFrame& frame) {
  switch (frame.colorspace) {
    case AVCOL_SPC_BT709:
      return SWS_CS_ITU709;
    case AVCOL_SPC_FCC:
      return SWS_CS_FCC;
    case AVCOL_SPC_BT470BG:
    case AVCOL_SPC_SMPTE170M:
      return SWS_CS_ITU601;
    case AVCOL_SPC_SMPTE240M:
      return SWS_CS_SMPTE240M;
    case AVCOL_SPC_BT2020_NCL:
    case AVCOL_SPC_BT2020_CL:
      return SWS_CS_BT2020;
    default:
      return frame.height >= 720 ? SWS_CS_ITU709 : SWS_CS_ITU601;
  }
}

}  // namespace

Hanging hanging_of(const std::int32_t* matrix) {
  const double a = matrix[0];
  const double b = matrix[1];
  const double c = matrix[3];
  const double d = matrix[4];
  // The images of "right" and "down" under one to three clockwise quarter turns.
  static constexpr int kTurns[4][4] = {{1, 0, 0, 1}, {0, 1, -1, 0}, {-1, 0, 0, -1}, {0, -1, 1, 0}};
  Hanging best;
  double best_match = 0;
  for (int turns = 0; turns < 4; ++turns) {
    for (const bool flip : {false, true}) {
      const auto& t = kTurns[turns];
      const double sign = flip ? -1 : 1;  // A horizontal flip negates what goes to p'.
      const double match = sign * a * t[0] + b * t[1] + sign * c * t[2] + d * t[3];
      if (match > best_match * (1 + 1e-9)) {
        best_match = match;
        best.orientation = {turns, flip, false};
      }
    }
  }
  const double straight = std::min(std::abs(a), std::abs(d));
  const double crossed = std::min(std::abs(b), std::abs(c));
  const double most_straight = std::max(std::abs(a), std::abs(d));
  const double most_crossed = std::max(std::abs(b), std::abs(c));
  best.exact =
      most_crossed <= 1e-3 * straight || most_straight <= 1e-3 * crossed || (most_straight == 0 && most_crossed == 0);
  return best;
}

cv::Size with_square_pixels(cv::Size coded, AVRational sample_aspect) {
  if (sample_aspect.num <= 0 || sample_aspect.den <= 0) return coded;
  const double width = std::round(double(coded.width) * sample_aspect.num / sample_aspect.den);
  return {static_cast<int>(std::clamp(width, 1.0, 1e9)), coded.height};
}

void PictureMaker::prepare(const AVFrame& frame) {
  const auto format = static_cast<AVPixelFormat>(frame.format);
  const auto* description = av_pix_fmt_desc_get(format);
  if (description == nullptr || sws_isSupportedInput(format) == 0) {
    throw failure(fmt::format("pixel format \"{}\" cannot be converted to colours",
                              description == nullptr ? "unknown" : description->name));
  }
  const Key key{frame.width, frame.height, frame.format, colour_space_of(frame),
                is_full_range(frame, *description, codec_)};
  if (context_ && key == key_) return;

  // The same bytes on every machine: no processor-dependent shortcuts, chroma interpolated and not repeated.
  const int flags = filter_ | SWS_ACCURATE_RND | SWS_BITEXACT | SWS_FULL_CHR_H_INT;
  context_.reset(sws_getContext(key.width, key.height, format, key.width, key.height, AV_PIX_FMT_BGR24, flags, nullptr,
                                nullptr, nullptr));
  if (!context_) {
    throw failure(fmt::format("pixel format \"{}\" at {}x{} cannot be converted to colours", description->name,
                              key.width, key.height));
  }
  // Refused for formats without a matrix, such as RGB, where there is nothing to set.
  (void)sws_setColorspaceDetails(context_.get(), sws_getCoefficients(key.colour_space), key.full_range ? 1 : 0,
                                 sws_getCoefficients(SWS_CS_DEFAULT), 1, 0, 1 << 16, 1 << 16);
  limited_grey_ = is_grey(*description) && !key.full_range;
  key_ = key;
}

cv::Mat PictureMaker::make(const AVFrame& frame, AVRational sample_aspect, const Orientation& orientation) {
  const cv::Size coded(frame.width, frame.height);
  prepare(frame);
  // FFmpeg's vector code may write past the end of a row, so rows get room to spare.
  const int padded_width = (coded.width + 63) / 32 * 32;
  if (padded_.rows != coded.height || padded_.cols != padded_width) padded_.create(coded.height, padded_width, CV_8UC3);
  std::uint8_t* planes[4] = {padded_.data, nullptr, nullptr, nullptr};
  const int strides[4] = {static_cast<int>(padded_.step[0]), 0, 0, 0};
  const int rows = sws_scale(context_.get(), frame.data, frame.linesize, 0, coded.height, planes, strides);
  if (rows != coded.height) throw failure(fmt::format("converting a frame of {}x{} failed", coded.width, coded.height));

  cv::Mat picture = padded_(cv::Rect(cv::Point(), coded));
  if (limited_grey_) widen_range(picture);
  const auto square = with_square_pixels(coded, sample_aspect);
  if (square.width != coded.width) {
    cv::Mat scaled;
    cv::resize(picture, scaled, square, 0, 0, square.width > coded.width ? cv::INTER_LINEAR_EXACT : cv::INTER_AREA);
    picture = scaled;
  }
  if (!orientation.is_identity()) return oriented(picture, orientation);
  return picture.data == padded_.data ? picture.clone() : picture;
}

}  // namespace choreo::devices
