// SPDX-License-Identifier: Apache-2.0
#include "devices/media/video_stream.hpp"

#include <algorithm>
#include <cstdlib>
#include <new>
#include <string_view>
#include <thread>

#include <fmt/format.h>

#include "core/error.hpp"

namespace choreo::devices {
namespace {

int should_interrupt(void* watch) {
  const auto& w = *static_cast<const Watch*>(watch);
  return w.stopped() || w.timed_out() ? 1 : 0;
}

// "00:00:10.033000000", as Matroska's statistics tags write a track's length.
std::optional<Nanoseconds> parse_clock(const char* text) {
  int hours = 0;
  int minutes = 0;
  double seconds = 0;
  if (std::sscanf(text, "%d:%d:%lf", &hours, &minutes, &seconds) != 3) return std::nullopt;
  if (hours < 0 || hours > 100'000 || minutes < 0 || minutes > 59 || !(seconds >= 0 && seconds < 61)) {
    return std::nullopt;
  }
  return std::chrono::hours(hours) + std::chrono::minutes(minutes) + from_seconds(seconds);
}

}  // namespace

void Watch::begin(std::stop_token stop, int patience_times) {
  read_stop_ = std::move(stop);
  deadline_ = std::chrono::steady_clock::now() + patience_ * patience_times;
}

VideoStream::VideoStream(const std::string& location, bool network, const OpenOptions& options, Nanoseconds patience)
    : location_(network ? without_password(location) : location),
      network_(network),
      watch_(options.stop, network, patience),
      packet_(av_packet_alloc()) {
  if (!packet_) throw std::bad_alloc();
  silence_libav();
  forget_libav_message();
  open_container(location, network);
  const auto choice = choose_video(*container_, location_);
  stream_ = choice.stream;
  codec_ = choice.codec;
  open_decoder(options.threads);
}

void VideoStream::refuse(int code, std::string_view doing) const {
  if (watch_.stopped()) throw failure(fmt::format("\"{}\": opening was interrupted", location_));
  if (watch_.timed_out()) {
    throw failure(
        fmt::format("\"{}\" does not answer: nothing came for {} s", location_, to_seconds(watch_.patience())), {},
        "check the address and whether the sender runs");
  }
  const auto said = without_password(last_libav_message());
  const auto cause = libav_error_text(code) + (said.empty() ? "" : fmt::format(" ({})", said));
  if (network_)
    throw usage_error(fmt::format("\"{}\" cannot be opened: {}", location_, cause), {}, "check the address");
  const bool lacks_index = said.find("moov atom not found") != std::string::npos;
  throw usage_error(
      fmt::format("\"{}\" {}: {}", location_, doing, cause), {},
      lacks_index ? "the index at its end is missing: the recording was cut off or never finished" : kWhatIsAVideo);
}

void VideoStream::open_container(const std::string& location, bool network) {
  auto* context = avformat_alloc_context();
  if (context == nullptr) throw std::bad_alloc();
  container_.reset(context);
  context->interrupt_callback = {should_interrupt, &watch_};
  std::string address = location;
  if (!network) {
    bytes_ = std::make_unique<ByteInput>(location, [this] { return watch_.stopped(); });
    context->pb = bytes_->context();
    context->flags |= AVFMT_FLAG_CUSTOM_IO;
    // A local playlist must not make us call out.
    context->protocol_whitelist = av_strdup("file,crypto,data");
    address = "file:" + location;
  }
  watch_.begin({});
  (void)container_.release();  // avformat_open_input frees it where it fails.
  const int opened = avformat_open_input(&context, address.c_str(), nullptr, nullptr);
  container_.reset(context);
  if (opened < 0) refuse(opened, "is not a video that FFmpeg can read");

  refuse_character_art(*context, location_);
  rates_ = DeclaredRates(*context);
  watch_.begin({}, 2);
  const int known = avformat_find_stream_info(context, nullptr);
  if (known < 0 || watch_.stopped() || watch_.timed_out()) refuse(known, "is not a video that FFmpeg can read");
}

void VideoStream::open_decoder(int threads) {
  decoder_.reset(avcodec_alloc_context3(codec_));
  if (!decoder_) throw std::bad_alloc();
  forget_libav_message();
  int result = avcodec_parameters_to_context(decoder_.get(), stream_->codecpar);
  decoder_->pkt_timebase = stream_->time_base;
  // Where frames build on each other, what several threads make of a damaged one differs from run to run. One thread
  // is fast enough: turning the frame into colours takes longer than decoding it.
  const auto* description = avcodec_descriptor_get(codec_->id);
  const bool stands_alone = description != nullptr && (description->props & AV_CODEC_PROP_INTRA_ONLY) != 0;
  decoder_->thread_count = stands_alone ? std::max(threads, 0) : 1;
  // Twice 8K in each direction: larger sizes come from damaged headers, and would only exhaust memory.
  decoder_->max_pixels = std::int64_t{16384} * 16384;
  if (result >= 0) result = avcodec_open2(decoder_.get(), codec_, nullptr);
  if (result < 0) refuse(result, fmt::format("holds \"{}\" video that FFmpeg cannot decode", codec_->name));
}

double VideoStream::nominal_fps() const { return rates_.fps(*stream_); }

std::optional<Nanoseconds> VideoStream::declared_duration() const {
  if (const auto* tag = av_dict_get(stream_->metadata, "DURATION", nullptr, 0)) {
    if (const auto duration = parse_clock(tag->value)) return duration;
  }
  if (container_->duration_estimation_method != AVFMT_DURATION_FROM_STREAM) return std::nullopt;
  if (const auto duration = libav_time(stream_->duration, stream_->time_base); duration && duration->count() > 0) {
    return duration;
  }
  if (container_->nb_streams > 1) return std::nullopt;
  const auto duration = libav_time(container_->duration, AVRational{1, AV_TIME_BASE});
  return duration && duration->count() > 0 ? duration : std::nullopt;
}

// Gives the decoder one packet, or the end. False where a stop was requested.
bool VideoStream::feed() {
  for (;;) {
    av_packet_unref(packet_.get());
    int result = av_read_frame(container_.get(), packet_.get());
    if (result == 0 && packet_->stream_index != stream_->index) continue;
    if (result < 0) {
      if (watch_.stopped()) {
        // FFmpeg remembers the interruption as the end; a later read may go on.
        if (container_->pb != nullptr) container_->pb->eof_reached = container_->pb->error = 0;
        return false;
      }
      if (result == AVERROR_EOF && container_->pb != nullptr && container_->pb->error < 0) {
        result = container_->pb->error;
      }
      // The wait may have run out in the call before, which still had a packet in store.
      if (watch_.timed_out() || (network_ && result == AVERROR_EXIT)) {
        throw failure(
            fmt::format("\"{}\" fell silent: nothing came for {} s", location_, to_seconds(watch_.patience())));
      }
      if (result == AVERROR(EAGAIN)) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        continue;
      }
      if (result != AVERROR_EOF) read_error_ = result;
      if (read_error_ != 0 && network_) {
        throw failure(fmt::format("\"{}\": the connection broke: {}", location_, libav_error_text(read_error_)));
      }
      draining_ = true;
      (void)avcodec_send_packet(decoder_.get(), nullptr);
      return true;
    }
    if (packet_->size == 0) continue;
    // The mark travels with the packet through reordering and decoder threads, and comes out on its frame.
    const bool damaged = (packet_->flags & AV_PKT_FLAG_CORRUPT) != 0 ||
                         (codec_->id == AV_CODEC_ID_FFV1 &&
                          ffv1_check_.is_damaged({packet_->data, static_cast<std::size_t>(packet_->size)}));
    decoder_->reordered_opaque = damaged ? 1 : 0;
    result = avcodec_send_packet(decoder_.get(), packet_.get());
    if (result == AVERROR(ENOMEM)) throw std::bad_alloc();
    if (result < 0 && result != AVERROR(EAGAIN)) ++damaged_;
    return true;
  }
}

VideoStream::Outcome VideoStream::next(AVFrame& frame, std::stop_token stop) {
  watch_.begin(std::move(stop));
  for (;;) {
    if (deinterlacer_ && deinterlacer_->pull(frame)) return Outcome::kFrame;
    if (deinterlacer_ && deinterlacer_->ended()) {
      deinterlacer_.reset();
      if (!waiting_) return Outcome::kEnd;
      av_frame_move_ref(&frame, waiting_.get());
      waiting_.reset();
    } else if (const auto outcome = decode(frame); outcome == Outcome::kEnd && deinterlacer_) {
      deinterlacer_->end();
      continue;
    } else if (outcome != Outcome::kFrame) {
      return outcome;
    }
    // Of another size or format: those before it come first.
    if (deinterlacer_ && !deinterlacer_->fits(frame)) {
      deinterlacer_->end();
      waiting_.reset(av_frame_alloc());
      if (!waiting_) throw std::bad_alloc();
      av_frame_move_ref(waiting_.get(), &frame);
      continue;
    }
    if (!deinterlacer_ && interlacing_.is_seen_in(frame)) deinterlacer_.emplace(frame, stream_->time_base);
    if (!deinterlacer_) return Outcome::kFrame;
    deinterlacer_->push(frame);
  }
}

// The decoder's next undamaged frame.
VideoStream::Outcome VideoStream::decode(AVFrame& frame) {
  constexpr int kMostErrorsWhileDraining = 256;
  for (;;) {
    if (watch_.stopped()) return Outcome::kStopped;
    const int result = avcodec_receive_frame(decoder_.get(), &frame);
    if (result == 0) {
      errors_in_a_row_ = 0;
      if (frame.width <= 0 || frame.height <= 0 || (frame.flags & AV_FRAME_FLAG_CORRUPT) != 0 ||
          frame.decode_error_flags != 0 || frame.reordered_opaque == 1) {
        ++damaged_;
        av_frame_unref(&frame);
        continue;
      }
      damaged_before_last_good_ = damaged_;
      return Outcome::kFrame;
    }
    if (result == AVERROR(ENOMEM)) throw std::bad_alloc();
    if (result == AVERROR_EOF || (result == AVERROR(EAGAIN) && draining_)) return Outcome::kEnd;
    if (result == AVERROR(EAGAIN)) {
      if (!feed()) return Outcome::kStopped;
    } else {
      ++damaged_;
      if (draining_ && ++errors_in_a_row_ > kMostErrorsWhileDraining) return Outcome::kEnd;
    }
  }
}

}  // namespace choreo::devices
