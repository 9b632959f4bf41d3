// SPDX-License-Identifier: Apache-2.0
// Streams from a V4L2 camera through memory that the driver shares.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "devices/device_source.hpp"
#include "devices/media/raw_converter.hpp"
#include "devices/v4l2/v4l2_node.hpp"

namespace choreo::devices::v4l2 {

/// What is wanted of a camera; what is left open the camera decides, or `choose_mode`.
struct Wish {
  std::string path;                  ///< Of the node, or a link to it.
  std::optional<Identity> identity;  ///< The device that was there before: `likeness_of`.
  std::optional<int> input;          ///< Of a card with several sockets; the one it is at where left open.
  std::optional<cv::Size> size;
  std::optional<double> fps;
  std::optional<std::uint32_t> fourcc;
  std::map<std::string, std::string> controls;  ///< By name, as `set_controls`.
  bool every_frame = false;                     ///< As OpenOptions.
  bool keep_raw = false;                        ///< As OpenOptions.
};

/// The mode to ask for: of those with a known format and the size, the one whose rate comes nearest, then the one that
/// loses the least. Without a size, 640 x 480 or what is nearest to it.
/// @return nothing where no mode fits.
[[nodiscard]] std::optional<Mode> choose_mode(const std::vector<Mode>& modes, const Wish& wish);

class Session final : public DeviceSession {
 public:
  /// Opens the node, chooses the mode, sets the controls and starts the stream.
  /// @throws DeviceLost; Error (usage) for a mode or a control that the camera has not.
  Session(const Wish& wish, const Clock& clock);
  ~Session() override;

  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  [[nodiscard]] const Identity& identity() const { return identity_; }
  [[nodiscard]] bool stamps_with_host_clock() const override { return host_clock_; }
  /// The newest frame that is there: older ones that wait are given back to the driver unseen, and their numbers are
  /// missing. Where all buffers were full, the driver had none left for what came since: these frames are old, and a
  /// new one is waited for. With `Wish::every_frame` the oldest. Buffers that the driver marks as damaged, or that are
  /// too short, are left out.
  [[nodiscard]] std::optional<DeviceFrame> wait(Nanoseconds patience) override;
  [[nodiscard]] std::uint64_t damaged() const override { return damaged_; }
  [[nodiscard]] std::vector<std::string> take_warnings() override;

 private:
  // Memory of the driver's.
  struct Buffer {
    Buffer(std::uint8_t* d, std::size_t b) : data(d), bytes(b) {}
    Buffer(Buffer&& other) noexcept : data(std::exchange(other.data, nullptr)), bytes(other.bytes) {}
    Buffer& operator=(Buffer&&) = delete;
    ~Buffer();
    std::uint8_t* data;
    std::size_t bytes;
  };

  void negotiate(const Wish& wish);
  void share_buffers();
  void give_back(v4l2_buffer& buffer);
  [[nodiscard]] bool take(v4l2_buffer& buffer);
  [[nodiscard]] std::optional<v4l2_buffer> take_newest();
  [[nodiscard]] std::optional<v4l2_buffer> take_oldest();
  [[nodiscard]] bool whole(const v4l2_buffer& buffer);

  const Clock& clock_;
  Node node_;
  Identity identity_;
  SourceInfo info_;
  Layout layout_;
  RawConverter converter_;
  bool every_frame_;
  bool keep_raw_;
  std::vector<Buffer> buffers_;
  std::vector<std::string> warnings_;
  bool host_clock_ = false;
  std::uint64_t damaged_ = 0;
};

}  // namespace choreo::devices::v4l2
