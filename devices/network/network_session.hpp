// SPDX-License-Identifier: Apache-2.0
// A camera on the network as a device that is open and streaming.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "devices/device_source.hpp"
#include "devices/media/picture.hpp"
#include "devices/media/raw_converter.hpp"
#include "devices/network/network_reader.hpp"

namespace choreo::devices::network {

class Session final : public DeviceSession {
 public:
  /// Begins to connect, and returns at once. Nothing but `is_ready` may be called until that is true.
  Session(const Wish& wish, const Clock& clock);

  /// Whether the first picture is there; waits for it for at most `wait` and some milliseconds.
  /// @throws DeviceLost where the sender is away, or the wish's patience is over; Error (usage) where it refuses us.
  [[nodiscard]] bool is_ready(Nanoseconds wait);
  [[nodiscard]] bool is_recording() const { return reader_.is_recording(); }

  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  /// Pictures without times are stamped as they arrive.
  [[nodiscard]] bool stamps_with_host_clock() const override { return !facts_.has_times; }
  /// The newest picture, or with `Wish::every_frame` the oldest of a few that wait (Reader::kMostWaiting); those that
  /// it overtook were never turned into colours, and their numbers are missing.
  [[nodiscard]] std::optional<DeviceFrame> wait(Nanoseconds patience) override;
  [[nodiscard]] std::vector<std::string> take_warnings() override;

 private:
  [[nodiscard]] std::optional<DeviceFrame> converted(const Picture& picture);
  [[nodiscard]] cv::Mat upright(const AVFrame& frame);

  const Wish wish_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  Reader reader_;
  Facts facts_;
  SourceInfo info_;
  RawConverter jpegs_;
  std::optional<PictureMaker> maker_;
  std::optional<DeviceFrame> first_;
  bool damaged_ = false;
  bool told_damaged_ = false;
};

}  // namespace choreo::devices::network
