// SPDX-License-Identifier: Apache-2.0
// Reads a device that may go away and come back.
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/time.hpp"
#include "devices/device_state.hpp"
#include "devices/device_time.hpp"
#include "devices/source.hpp"

namespace choreo::devices {

/// A frame as a driver hands it over.
struct DeviceFrame {
  std::uint32_t counter = 0;   ///< The device's own, which may wrap; a gap is a frame that was lost.
  Nanoseconds device_time{0};  ///< On the device's clock.
  Nanoseconds arrival{0};      ///< On the host's monotonic clock, as it was handed over.
  cv::Mat bgr;                 ///< This and the rest as in Frame.
  cv::Mat depth = {};
  RawPicturePtr raw_colour = {};
  RawPicturePtr raw_depth = {};
};

/// A device that is open and streaming.
///
/// Made by opening; destroying it closes the device. Once it has thrown it is only destroyed.
/// @thread thread-bound
class DeviceSession {
 public:
  virtual ~DeviceSession() = default;
  DeviceSession() = default;
  DeviceSession(const DeviceSession&) = delete;
  DeviceSession& operator=(const DeviceSession&) = delete;

  [[nodiscard]] virtual const SourceInfo& info() const = 0;
  /// Whether `DeviceFrame::device_time` is on the host's monotonic clock.
  [[nodiscard]] virtual bool stamps_with_host_clock() const = 0;
  /// The next frame; nothing where none came within `patience`, at most some milliseconds late.
  /// @throws DeviceLost where the device is gone or must be opened anew.
  [[nodiscard]] virtual std::optional<DeviceFrame> wait(Nanoseconds patience) = 0;
  /// Frames that came, but damaged, and were left out.
  [[nodiscard]] virtual std::uint64_t damaged() const { return 0; }
  /// What else was not as it should be since the last call, one line each.
  [[nodiscard]] virtual std::vector<std::string> take_warnings() { return {}; }
};

/// Opens the device with all its settings.
/// @param stop  ends any wait inside.
/// @throws DeviceLost where it is not there now, or stop is requested; Error (usage) where it can never give what is
///   asked for.
using OpenSession = std::function<std::unique_ptr<DeviceSession>(const std::stop_token& stop)>;

struct DeviceOptions {
  OnDeviceEvent on_event;                              ///< May be empty.
  std::stop_token stop = {};                           ///< Ends a wait in the first opening; `read` has its own.
  Nanoseconds retry = std::chrono::milliseconds(250);  ///< How long to wait between attempts to open a lost device.
  double silent_frames = 15;                           ///< A device that misses so many frames in a row is lost,
  Nanoseconds least_silence = std::chrono::milliseconds(400);  ///< but not before this,
  Nanoseconds most_silence = std::chrono::milliseconds(900);   ///< nor after this,
  double least_frames = 3;                                     ///< but never before it has missed so many.
  Nanoseconds first_frame = std::chrono::seconds(3);           ///< And so long for the first: cameras warm up.
};

/// A device as a source: its frames on the host's clock, numbered through, for as long as anybody reads.
///
/// A device that vanishes, breaks or stays silent is lost: that is told at once, before it is closed, and it is opened
/// anew, with its settings, as soon as it is there again. `read` returns only with a frame, or because stop was
/// requested.
/// @thread thread-bound, but for `state`
class DeviceSource final : public Source {
 public:
  /// Opens the device.
  /// @throws Error (usage) where it is not there or cannot give what is asked for: whoever starts a run wants to know.
  DeviceSource(std::string name, OpenSession open, const Clock& clock, DeviceOptions options = {});
  ~DeviceSource() override;

  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  [[nodiscard]] FramePtr read(std::stop_token stop) override;
  [[nodiscard]] std::vector<std::string> warnings() const override;

  /// @thread thread-safe
  [[nodiscard]] DeviceState state() const;

 private:
  void open(const std::stop_token& stop);
  [[nodiscard]] FramePtr read_next(const std::stop_token& stop);
  void enter(DeviceState state, const std::string& why = {});
  void lose(const std::string& why);
  void warn(std::string line);
  [[nodiscard]] bool reopen(const std::stop_token& stop);
  [[nodiscard]] Nanoseconds longest_silence() const;

  std::string name_;
  OpenSession open_;
  const Clock& clock_;
  DeviceOptions options_;
  SourceInfo info_;
  std::unique_ptr<DeviceSession> session_;
  DeviceClock device_clock_;
  FrameCounter counter_;
  Nanoseconds last_heard_{0};
  Nanoseconds left_at_{0};  // When `read`, or the constructor, returned last.
  bool first_ = true;       // No frame has come since the device was opened.
  bool pause_ = false;      // Before it is opened again: it is away, or gave nothing the last time.
  std::optional<Nanoseconds> last_time_;
  std::size_t losses_ = 0;             // Of a device that ran.
  std::uint64_t damaged_before_ = 0;   // By sessions that are closed.
  std::vector<std::string> warnings_;  // The first ones.
  std::uint64_t left_out_warnings_ = 0;
  mutable std::mutex mutex_;
  DeviceState state_ = DeviceState::kStopped;
};

}  // namespace choreo::devices
