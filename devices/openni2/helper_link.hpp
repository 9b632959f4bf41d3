// SPDX-License-Identifier: Apache-2.0
// The helper's end of the conversation.
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>

#include "devices/openni2/protocol.hpp"

namespace choreo::devices::openni2 {

/// Ours is the only program that speaks to us; where it is gone, so are we.
/// @thread thread-safe: `send`; thread-bound: the rest
class HelperLink {
 public:
  /// Maps the memory. @throws std::runtime_error where this program was not started by choreoscope.
  HelperLink();
  HelperLink(const HelperLink&) = delete;
  HelperLink& operator=(const HelperLink&) = delete;

  void send(const Message& message);
  /// The next message that is no Release, which are taken note of; nothing where none comes in time.
  /// @throws BadMessage
  [[nodiscard]] std::optional<Message> receive(int milliseconds);

  /// A place that is free, and stays so until a Picture in it is sent.
  [[nodiscard]] std::optional<std::uint32_t> free_slot() const;
  [[nodiscard]] std::span<std::uint8_t> slot(std::uint32_t number);
  void send_picture(const Picture& picture);

  /// Whether choreoscope has hung up, or is gone.
  [[nodiscard]] bool closed() const { return closed_; }

 private:
  std::mutex mutex_;
  std::uint8_t* memory_ = nullptr;
  std::array<bool, kSlots> taken_{};
  bool closed_ = false;
};

}  // namespace choreo::devices::openni2
