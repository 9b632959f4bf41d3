// SPDX-License-Identifier: Apache-2.0
#include "devices/network/network_stream.hpp"

#include <cstring>
#include <new>
#include <string_view>
#include <thread>
#include <utility>

#include <fmt/format.h>

extern "C" {
#include <libavutil/dict.h>
}

#include "core/error.hpp"
#include "devices/source_uri.hpp"

namespace choreo::devices::network {
namespace {

// What a server may lead us to: never a file of this machine.
constexpr const char* kProtocols =
    "crypto,data,http,httpproxy,https,rtmp,rtmpe,rtmps,rtmpt,rtp,rtsp,rtsps,srt,srtp,tcp,tls,udp";

// A picture that is older than the last one by more is no late one: the sender's clock began anew.
constexpr Nanoseconds kLatest = std::chrono::seconds(1);

int should_interrupt(void* guard) { return static_cast<Guard*>(guard)->interrupts() ? 1 : 0; }

}  // namespace

void Guard::watch(const AVFormatContext* container) {
  container_ = container;
  bytes_before_ = container == nullptr || container->pb == nullptr ? 0 : container->pb->bytes_read;
}

bool Guard::interrupts() {
  if (container_ != nullptr && container_->pb != nullptr) {
    flooded_ = flooded_ || container_->pb->bytes_read - bytes_before_ > kMostBytes;
  }
  return stopped() || late() || flooded_;
}

Stream::Stream(const Wish& wish, Guard& guard, std::function<Nanoseconds()> now)
    : wish_(wish), guard_(guard), now_(std::move(now)), packet_(av_packet_alloc()) {
  if (!packet_) throw std::bad_alloc();
  silence_libav();
  forget_libav_message();
  open();
  const auto choice = choose_video(*container_, wish_.name);
  stream_ = choice.stream;
  if (codec() != AV_CODEC_ID_MJPEG) open_decoder(*choice.codec);
}

void Stream::refuse(int code, std::string_view doing) const {
  if (guard_.late()) {
    throw DeviceLost(
        fmt::format("\"{}\" does not answer: no picture came within {} s", wish_.name, to_seconds(wish_.patience)));
  }
  if (guard_.flooded()) throw usage_error(fmt::format("\"{}\" sends without end, but no video", wish_.name));
  const auto text = libav_error_text(code);
  const auto said = without_password(last_libav_message());
  const auto cause = said.empty() || said.find(text) != std::string::npos ? text : fmt::format("{} ({})", text, said);
  switch (code) {
    case AVERROR_HTTP_UNAUTHORIZED:
    case AVERROR_HTTP_FORBIDDEN:
      throw usage_error(fmt::format("\"{}\" does not let us in: {}", wish_.name, text), {},
                        "write name and password into the address, as in rtsp://name:password@host/path");
    case AVERROR_HTTP_BAD_REQUEST:
    case AVERROR_HTTP_NOT_FOUND:
    case AVERROR_HTTP_OTHER_4XX:
      throw usage_error(fmt::format("\"{}\" is not there: {}", wish_.name, text), {},
                        "check the path behind the name of the host");
    case AVERROR_INVALIDDATA:
    case AVERROR_DEMUXER_NOT_FOUND:
    case AVERROR_PROTOCOL_NOT_FOUND:
    case AVERROR(EINVAL):
      throw usage_error(fmt::format("\"{}\" {}: {}", wish_.name, doing, cause), {},
                        "a camera's manual names the address of its stream");
    default:
      throw DeviceLost(fmt::format("\"{}\" cannot be reached: {}", wish_.name, cause));
  }
}

void Stream::open() {
  auto* context = avformat_alloc_context();
  if (context == nullptr) throw std::bad_alloc();
  context->interrupt_callback = {should_interrupt, &guard_};
  context->protocol_whitelist = av_strdup(kProtocols);
  // What is read to find out about the stream is kept, and not thrown away as "nobuffer" would: it holds the picture
  // that the next ones build upon. It adds no delay, since whatever is there is decoded at once.
  context->fps_probe_size = 0;
  AVDictionary* settings = nullptr;
  if (wish_.address.starts_with("rtsp")) {
    av_dict_set(&settings, "rtsp_transport", wish_.transport.c_str(), 0);
    // A sender that calls us says itself what it sends.
    av_dict_set(&settings, wish_.listen ? "rtsp_flags" : "allowed_media_types", wish_.listen ? "listen" : "video", 0);
  }
  guard_.limit(wish_.patience);
  guard_.watch(context);
  const int opened = avformat_open_input(&context, wish_.address.c_str(), nullptr, &settings);
  av_dict_free(&settings);
  if (opened < 0) {
    guard_.watch(nullptr);  // FFmpeg has freed it.
    refuse(opened, "is no video that FFmpeg can read");
  }
  container_.reset(context);
  refuse_character_art(*context, wish_.name);
  rates_ = DeclaredRates(*context);
  const int known = avformat_find_stream_info(context, nullptr);
  if (known < 0 || guard_.interrupts()) refuse(known, "is no video that FFmpeg can read");
}

void Stream::open_decoder(const AVCodec& codec) {
  decoder_.reset(avcodec_alloc_context3(&codec));
  if (!decoder_) throw std::bad_alloc();
  int result = avcodec_parameters_to_context(decoder_.get(), stream_->codecpar);
  decoder_->pkt_timebase = stream_->time_base;
  // No picture is held back: a thread a picture would, a thread a slice does not.
  decoder_->flags |= AV_CODEC_FLAG_LOW_DELAY;
  decoder_->thread_type = FF_THREAD_SLICE;
  decoder_->thread_count = wish_.threads;
  decoder_->max_pixels = std::int64_t{16384} * 16384;  // Larger sizes come from damaged headers.
  if (result >= 0) result = avcodec_open2(decoder_.get(), &codec, nullptr);
  if (result < 0) {
    throw usage_error(fmt::format("\"{}\" sends \"{}\" video that FFmpeg cannot decode: {}", wish_.name, codec.name,
                                  libav_error_text(result)));
  }
}

bool Stream::is_recording() const {
  if (!wish_.address.starts_with("http") || std::strcmp(container_->iformat->name, "mpjpeg") == 0) return false;
  if (container_->duration > 0 && container_->duration_estimation_method != AVFMT_DURATION_FROM_BITRATE) return true;
  return (container_->iformat->flags & AVFMT_NO_BYTE_SEEK) == 0 && container_->pb != nullptr &&
         avio_size(container_->pb) > 0;
}

bool Stream::has_times() const { return (container_->iformat->flags & AVFMT_NOTIMESTAMPS) == 0; }

AVCodecID Stream::codec() const { return stream_->codecpar->codec_id; }

double Stream::nominal_fps() const {
  // Without times the rate is FFmpeg's guess, always 25.
  return has_times() ? rates_.fps(*stream_) : 0;
}

cv::Size Stream::coded_size() const { return {stream_->codecpar->width, stream_->codecpar->height}; }

// @return whether there is one; none where the guard stopped.
bool Stream::receive_packet() {
  for (;;) {
    av_packet_unref(packet_.get());
    guard_.watch(container_.get());
    int result = av_read_frame(container_.get(), packet_.get());
    packet_arrival_ = now_();
    if (guard_.stopped()) return false;
    if (result == 0) {
      if (packet_->stream_index == stream_->index && packet_->size > 0) return true;
      if (!guard_.late()) continue;
    }
    if (guard_.late()) refuse(result, {});
    if (guard_.flooded()) throw DeviceLost(fmt::format("\"{}\" sends without end, but no picture", wish_.name));
    if (result == AVERROR(EAGAIN)) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      continue;
    }
    // Where the bytes end, demuxers call it what they like.
    if (const auto* bytes = container_->pb; bytes != nullptr && bytes->eof_reached != 0) {
      result = bytes->error < 0 ? bytes->error : AVERROR_EOF;
    }
    // EIO is FFmpeg's word for a reply by HTTP that ends and never said where.
    if (result == AVERROR_EOF || result == AVERROR(EIO)) {
      throw DeviceLost(fmt::format("\"{}\": the sender ended the stream", wish_.name));
    }
    throw DeviceLost(fmt::format("\"{}\": the connection broke: {}", wish_.name, libav_error_text(result)));
  }
}

// @return false where the picture comes too late to be shown.
bool Stream::stamp(Picture& picture, std::int64_t units) {
  const auto sent = has_times() ? libav_time(units, stream_->time_base) : std::nullopt;
  if (sent) {
    const bool late = last_stamp_ && *sent <= *last_stamp_ && *last_stamp_ - *sent < kLatest;
    if (late) return false;
    picture.stamp = *sent;
  } else {
    picture.stamp = last_stamp_ ? *last_stamp_ + (picture.arrival - last_arrival_) : picture.arrival;
  }
  last_stamp_ = picture.stamp;
  last_arrival_ = picture.arrival;
  return true;
}

std::optional<Picture> Stream::next() { return codec() == AV_CODEC_ID_MJPEG ? next_jpeg() : next_decoded(); }

std::optional<Picture> Stream::next_jpeg() {
  for (;;) {
    if (!receive_packet()) return std::nullopt;
    Picture picture;
    picture.counter = counter_++;
    picture.arrival = packet_arrival_;
    if (!stamp(picture, packet_->pts)) continue;
    picture.jpeg = std::exchange(packet_, Libav<AVPacket>(av_packet_alloc()));
    if (!packet_) throw std::bad_alloc();
    return picture;
  }
}

std::optional<Picture> Stream::next_decoded() {
  Libav<AVFrame> frame(av_frame_alloc());
  if (!frame) throw std::bad_alloc();
  for (;;) {
    int result = avcodec_receive_frame(decoder_.get(), frame.get());
    if (result == AVERROR(EAGAIN)) {
      if (!receive_packet()) return std::nullopt;
      decoder_->reordered_opaque = packet_arrival_.count();  // Comes out on the frame.
      result = avcodec_send_packet(decoder_.get(), packet_.get());
      if (result < 0) ++damaged_;
      continue;
    }
    if (result == AVERROR(ENOMEM)) throw std::bad_alloc();
    if (result == AVERROR_EOF) throw DeviceLost(fmt::format("\"{}\": the sender ended the stream", wish_.name));
    Picture picture;
    picture.counter = counter_++;
    if (result < 0 || (frame->flags & AV_FRAME_FLAG_CORRUPT) != 0 || frame->decode_error_flags != 0) {
      ++damaged_;
      av_frame_unref(frame.get());
      continue;
    }
    picture.arrival = Nanoseconds(frame->reordered_opaque);
    if (!last_stamp_) damaged_ = 0;  // Whoever comes in the middle cannot read what builds on the beginning.
    if (!stamp(picture, frame->best_effort_timestamp)) continue;
    frame->sample_aspect_ratio = av_guess_sample_aspect_ratio(container_.get(), stream_, frame.get());
    picture.frame = std::move(frame);
    return picture;
  }
}

}  // namespace choreo::devices::network
