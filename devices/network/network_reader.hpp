// SPDX-License-Identifier: Apache-2.0
// A thread that reads a camera on the network without pause, and keeps its newest picture, or a few.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "devices/network/network_stream.hpp"

namespace choreo::devices::network {

/// What is known of a stream before its first picture.
struct Facts {
  AVCodecID codec = AV_CODEC_ID_NONE;
  bool has_times = false;
  double nominal_fps = 0;
  cv::Size coded;
};

/// Connects and reads in a thread of its own, named "network", until it is destroyed or the stream ends.
///
/// Newer pictures replace those that nobody took; where the wish is every frame, only those before the last
/// `kMostWaiting`. Destroying ends within a fraction of a second, whatever the peer
/// does: where the thread hangs in the name resolver, which nothing can interrupt, it is left to end by itself.
/// @thread thread-safe
class Reader {
 public:
  static constexpr std::size_t kMostWaiting = 8;

  Reader(const Wish& wish, const Clock& clock);
  ~Reader();
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  /// The oldest picture that waits, once; nothing where none came within `patience` or `is_recording`.
  /// @throws DeviceLost where there is none and never will be; Error (usage) where the peer refused us at the opening.
  [[nodiscard]] std::optional<Picture> take(Nanoseconds patience);

  /// Known once a picture was taken.
  [[nodiscard]] Facts facts() const;
  /// The address is that of a recording (Stream::is_recording), which is not read here.
  [[nodiscard]] bool is_recording() const;
  [[nodiscard]] std::uint64_t damaged() const;

 private:
  struct State;
  static void run(State& state);

  std::shared_ptr<State> state_;
  std::thread thread_;
};

}  // namespace choreo::devices::network
