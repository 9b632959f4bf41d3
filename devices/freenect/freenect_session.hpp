// SPDX-License-Identifier: Apache-2.0
// Streams from a first Kinect through libfreenect, in a thread of its own.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "devices/device_source.hpp"
#include "devices/freenect/pairing.hpp"

namespace choreo::devices::freenect {

enum class DepthView { kRegistered, kRaw, kOff };

/// What is wanted of a Kinect.
struct Wish {
  std::string serial;      ///< Empty for the first there is.
  bool was_there = false;  ///< It was open before: whatever keeps it from opening now may mend itself.
  DepthView depth = DepthView::kRegistered;
  bool infrared = false;       ///< In place of colour; then depth is as the depth camera, which is the same, sees it.
  std::optional<int> led;      ///< freenect_led_options; left alone where nothing.
  std::optional<double> tilt;  ///< Degrees upwards; likewise.
  bool keep_raw = false;       ///< As OpenOptions.
  bool every_frame = false;    ///< Likewise.
};

/// Every call to the library comes from one thread, "freenect". Its callbacks copy a picture and swap buffers, nothing
/// else. Should the library not come back from a call, the thread is given up and the session ends all the same.
class Session final : public DeviceSession {
 public:
  static constexpr std::size_t kMostWaiting = 8;

  /// @param stop  ends the wait for it.
  /// @throws DeviceLost where it is not there, does not answer or stop is requested; Error (usage) where it may not be
  ///   opened, or the library lacks what is wanted. A motor or an LED that cannot be had is a warning.
  Session(const Wish& wish, const Clock& clock, const std::stop_token& stop);
  ~Session() override;

  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  /// Empty where the library cannot tell.
  [[nodiscard]] std::string serial() const;
  [[nodiscard]] bool stamps_with_host_clock() const override { return false; }
  /// The newest pair, or with `Wish::every_frame` the oldest of the last `kMostWaiting`; those that were replaced show
  /// as a gap in its number.
  [[nodiscard]] std::optional<DeviceFrame> wait(Nanoseconds patience) override;
  [[nodiscard]] std::vector<std::string> take_warnings() override;

 private:
  struct Shared;
  static void run(const std::shared_ptr<Shared>& shared) noexcept;
  static void stream(Shared& shared);
  void end(Nanoseconds patience) noexcept;
  [[noreturn]] void tell_why() const;

  Wish wish_;
  SourceInfo info_;
  std::shared_ptr<Shared> shared_;
  std::thread thread_;
  Shot colour_;
  Shot depth_;
  TickClock ticks_;
};

}  // namespace choreo::devices::freenect
