// SPDX-License-Identifier: Apache-2.0
// Opens a recording or network stream with FFmpeg, chooses its video and decodes it.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "devices/media/byte_input.hpp"
#include "devices/media/deinterlacer.hpp"
#include "devices/media/ffv1_check.hpp"
#include "devices/media/libav.hpp"
#include "devices/media/video_choice.hpp"
#include "devices/registry.hpp"

namespace choreo::devices {

/// When FFmpeg must stop waiting: on request, and for a network also when a peer stays silent.
class Watch {
 public:
  Watch(std::stop_token open_stop, bool network, Nanoseconds patience)
      : open_stop_(std::move(open_stop)), network_(network), patience_(patience) {}

  /// A wait begins that `stop` may end too, and whose time is limited on a network.
  void begin(std::stop_token stop, int patience_times = 1);
  [[nodiscard]] bool stopped() const { return open_stop_.stop_requested() || read_stop_.stop_requested(); }
  [[nodiscard]] bool timed_out() const { return network_ && std::chrono::steady_clock::now() > deadline_; }
  [[nodiscard]] Nanoseconds patience() const { return patience_; }

 private:
  std::stop_token open_stop_;
  std::stop_token read_stop_;
  bool network_;
  Nanoseconds patience_;
  std::chrono::steady_clock::time_point deadline_{};
};

/// The video of a file or address, as decoded frames in presentation order.
/// @thread thread-bound
class VideoStream {
 public:
  /// @param location  a path, or an address with its scheme where `network`.
  /// @param patience  how long a network peer may stay silent.
  /// @throws Error (usage) where there is no video that FFmpeg can read; Error (failure) where a peer stays silent
  ///   or a stop was requested.
  VideoStream(const std::string& location, bool network, const OpenOptions& options, Nanoseconds patience);
  // FFmpeg keeps pointers to members.
  VideoStream(const VideoStream&) = delete;
  VideoStream& operator=(const VideoStream&) = delete;

  enum class Outcome { kFrame, kEnd, kStopped };

  /// Fills `frame` with the next undamaged frame, deinterlaced from the first one on that is interlaced.
  /// @throws Error (failure) where a network connection breaks or falls silent.
  Outcome next(AVFrame& frame, std::stop_token stop);

  [[nodiscard]] AVFormatContext& container() const { return *container_; }
  [[nodiscard]] AVStream& stream() const { return *stream_; }
  [[nodiscard]] bool is_regular_file() const { return bytes_ && bytes_->is_regular(); }

  /// Declared frame rate in Hz; 0 where none is declared.
  [[nodiscard]] double nominal_fps() const;
  /// Declared length of the video itself, not of longer sound beside it; nothing where it is merely estimated.
  [[nodiscard]] std::optional<Nanoseconds> declared_duration() const;

  /// Frames left out as damaged, in all and since the last good one.
  [[nodiscard]] std::uint64_t damaged() const { return damaged_; }
  [[nodiscard]] std::uint64_t damaged_at_the_end() const { return damaged_ - damaged_before_last_good_; }
  /// FFmpeg's error that ended reading; 0 where the end was reached in order.
  [[nodiscard]] int read_error() const { return read_error_; }

 private:
  void open_container(const std::string& location, bool network);
  void open_decoder(int threads);
  [[noreturn]] void refuse(int code, std::string_view doing) const;
  bool feed();
  Outcome decode(AVFrame& frame);

  std::string location_;
  bool network_;
  Watch watch_;
  std::unique_ptr<ByteInput> bytes_;  // Before the container, which reads from it until it is closed.
  Libav<AVFormatContext> container_;
  DeclaredRates rates_;
  AVStream* stream_ = nullptr;
  const AVCodec* codec_ = nullptr;
  Libav<AVCodecContext> decoder_;
  Libav<AVPacket> packet_;
  Ffv1Check ffv1_check_;
  Interlacing interlacing_;
  std::optional<Deinterlacer> deinterlacer_;
  Libav<AVFrame> waiting_;  // For those in the deinterlacer.
  bool draining_ = false;
  int errors_in_a_row_ = 0;
  int read_error_ = 0;
  std::uint64_t damaged_ = 0;
  std::uint64_t damaged_before_last_good_ = 0;
};

}  // namespace choreo::devices
