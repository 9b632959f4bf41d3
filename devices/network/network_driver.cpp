// SPDX-License-Identifier: Apache-2.0
#include "devices/network/network_driver.hpp"

#include <algorithm>
#include <exception>
#include <stop_token>
#include <utility>

#include <fmt/format.h>

#include "core/error.hpp"
#include "devices/network/network_session.hpp"

namespace choreo::devices {
namespace {

constexpr Nanoseconds kSlice = std::chrono::milliseconds(50);
// Taking up again is tried anew after this, or twice what the first opening took: a camera that was switched off may
// never answer what it was sent before.
constexpr Nanoseconds kReopening = std::chrono::seconds(3);

// The address is none of a camera. Passes through whoever supervises cameras.
class RecordingFound : public std::exception {};

// Opens sessions of one address; from the second on without waiting, so that whoever reads can be stopped.
class Camera {
 public:
  Camera(network::Wish wish, const Clock& clock) : wish_(std::move(wish)), clock_(clock) {}

  std::unique_ptr<DeviceSession> open(const std::stop_token& stop) { return opened_ ? reopen() : open_first(stop); }

 private:
  std::unique_ptr<DeviceSession> open_first(const std::stop_token& stop) {
    const auto begin = clock_.now();
    auto session = std::make_unique<network::Session>(wish_, clock_);
    try {
      while (!session->is_ready(kSlice)) {
        if (session->is_recording()) throw RecordingFound();
        if (stop.stop_requested()) throw failure(fmt::format("\"{}\": opening was interrupted", wish_.name));
      }
    } catch (const DeviceLost& lost) {
      throw usage_error(lost.what(), {}, "check the address, and whether the camera runs");
    }
    opened_ = true;
    wish_.patience = std::min(wish_.patience, std::max(kReopening, 2 * (clock_.now() - begin)));
    return session;
  }

  std::unique_ptr<DeviceSession> reopen() {
    if (!next_) next_ = std::make_unique<network::Session>(wish_, clock_);
    try {
      if (next_->is_ready(kSlice)) return std::move(next_);
      if (next_->is_recording()) throw DeviceLost(fmt::format("\"{}\" holds a recording now", wish_.name));
    } catch (...) {
      next_.reset();
      throw;
    }
    throw DeviceLost(fmt::format("\"{}\" does not answer yet", wish_.name));
  }

  network::Wish wish_;
  const Clock& clock_;
  bool opened_ = false;
  std::unique_ptr<network::Session> next_;
};

std::unique_ptr<Source> open(const SourceUri& uri, SettingReader& settings, const OpenOptions& options,
                             const Clock& clock, const OpenRemoteRecording& recordings) {
  network::Wish wish;
  wish.address = uri.location;
  wish.name = without_password(uri.location);
  wish.patience = from_seconds(settings.take_number("patience", 10, 0.1, 600));
  const auto silence = from_seconds(settings.take_number("silence", 0.8, 0.1, 600));
  if (uri.scheme.starts_with("rtsp")) {
    static const std::vector<std::string> kTransports = {"tcp", "udp"};
    // Over UDP a busy network loses packets, and every loss is a broken picture.
    wish.transport = settings.take_choice("transport", "tcp", kTransports);
    wish.listen = settings.take_flag("listen", false);
  }
  settings.refuse_the_rest();
  wish.threads = options.threads;
  wish.keep_raw = options.keep_raw;
  wish.every_frame = options.every_frame;

  DeviceOptions device;
  device.on_event = options.on_event;
  device.stop = options.stop;
  // A network stumbles more often than a cable, whatever the frame rate.
  device.least_silence = device.most_silence = silence;
  const auto camera = std::make_shared<Camera>(wish, clock);
  try {
    return std::make_unique<DeviceSource>(
        uri.text, [camera](const std::stop_token& stop) { return camera->open(stop); }, clock, std::move(device));
  } catch (const RecordingFound&) {
    return recordings(uri, options, wish.patience);
  }
}

}  // namespace

Driver network_driver(const Clock& clock, OpenRemoteRecording recordings) {
  Driver driver;
  driver.scheme = "rtsp";
  driver.also_schemes = {"rtsps", "http", "https", "rtmp", "srt", "udp", "tcp", "rtp"};
  driver.example = "rtsp://name:password@camera/stream";
  driver.summary = "a camera on the network, or a recording behind an http address";
  driver.open = [&clock, recordings = std::move(recordings)](const SourceUri& uri, SettingReader& settings,
                                                             const OpenOptions& options) {
    return open(uri, settings, options, clock, recordings);
  };
  return driver;
}

}  // namespace choreo::devices
