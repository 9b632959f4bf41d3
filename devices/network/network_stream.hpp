// SPDX-License-Identifier: Apache-2.0
// Opens a camera on the network with FFmpeg and gives its pictures as they come.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "devices/device_source.hpp"
#include "devices/media/libav.hpp"
#include "devices/media/video_choice.hpp"

namespace choreo::devices::network {

/// What is wanted of an address.
struct Wish {
  std::string address;            ///< As FFmpeg reads it, with its password.
  std::string name;               ///< As messages say it.
  std::string transport = "tcp";  ///< Of RTP behind rtsp: "tcp" or "udp".
  bool listen = false;            ///< Of rtsp: wait for a sender to call.
  int threads = 0;                ///< As OpenOptions.
  bool keep_raw = false;          ///< Likewise.
  bool every_frame = false;       ///< Likewise.
  Nanoseconds patience{0};        ///< How long opening may take, up to the first picture.
};

/// Tells FFmpeg when to stop waiting.
///
/// @thread thread-bound to whoever waits, but for `stop` and `stopped`
class Guard {
 public:
  void stop() { stop_ = true; }
  [[nodiscard]] bool stopped() const { return stop_; }

  void limit(Nanoseconds patience) { deadline_ = std::chrono::steady_clock::now() + patience; }
  void unlimit() { deadline_.reset(); }
  [[nodiscard]] bool late() const { return deadline_ && std::chrono::steady_clock::now() > *deadline_; }

  /// Whose bytes are counted from now on; null before it is freed.
  void watch(const AVFormatContext* container);
  /// Somebody sends without end, and no packet: `kMostBytes` since `watch`.
  [[nodiscard]] bool flooded() const { return flooded_; }

  /// Asked by FFmpeg all the time.
  [[nodiscard]] bool interrupts();

 private:
  static constexpr std::int64_t kMostBytes = std::int64_t{64} << 20U;

  std::atomic<bool> stop_{false};
  std::optional<std::chrono::steady_clock::time_point> deadline_;
  const AVFormatContext* container_ = nullptr;
  std::int64_t bytes_before_ = 0;
  bool flooded_ = false;
};

/// One picture, not yet in colours.
struct Picture {
  std::uint32_t counter = 0;
  Nanoseconds stamp{0};    ///< The sender's, or `arrival` where it sends none.
  Nanoseconds arrival{0};  ///< As its last packet came.
  Libav<AVPacket> jpeg;    ///< A picture of motion JPEG as it came; else null.
  Libav<AVFrame> frame;    ///< Any other, decoded.
};

/// The video behind an address.
/// @thread thread-bound
class Stream {
 public:
  /// Waits at most as long as `guard` allows.
  /// @param now  the host's monotonic clock.
  /// @throws DeviceLost where the sender is away or silent; Error (usage) where it refuses us or sends no video.
  Stream(const Wish& wish, Guard& guard, std::function<Nanoseconds()> now);
  // FFmpeg keeps pointers to members.
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  /// A file rather than a camera: its container declares a duration, or the server of an address with http the number
  /// of its bytes (of a playlist these say nothing).
  [[nodiscard]] bool is_recording() const;
  /// Whether the sender stamps its pictures. Multipart JPEG has no times.
  [[nodiscard]] bool has_times() const;
  [[nodiscard]] AVCodecID codec() const;
  [[nodiscard]] double nominal_fps() const;  ///< 0 where none is declared.
  [[nodiscard]] cv::Size coded_size() const;

  /// The next picture, with its sample aspect ratio. Damaged ones, and such as are older than one already given, are
  /// left out: the counter tells.
  /// @return nothing where the guard stopped.
  /// @throws DeviceLost at the end, or where the connection breaks.
  [[nodiscard]] std::optional<Picture> next();
  /// How many were damaged so far.
  [[nodiscard]] std::uint64_t damaged() const { return damaged_; }

 private:
  void open();
  [[noreturn]] void refuse(int code, std::string_view doing) const;
  void open_decoder(const AVCodec& codec);
  [[nodiscard]] bool receive_packet();
  [[nodiscard]] std::optional<Picture> next_jpeg();
  [[nodiscard]] std::optional<Picture> next_decoded();
  [[nodiscard]] bool stamp(Picture& picture, std::int64_t units);

  const Wish wish_;
  Guard& guard_;
  std::function<Nanoseconds()> now_;
  Libav<AVFormatContext> container_;
  DeclaredRates rates_;
  AVStream* stream_ = nullptr;
  Libav<AVCodecContext> decoder_;  // Null for JPEG.
  Libav<AVPacket> packet_;
  std::uint32_t counter_ = 0;
  std::uint64_t damaged_ = 0;
  Nanoseconds packet_arrival_{0};
  std::optional<Nanoseconds> last_stamp_;
  Nanoseconds last_arrival_{0};
};

}  // namespace choreo::devices::network
