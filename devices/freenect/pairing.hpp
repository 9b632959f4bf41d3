// SPDX-License-Identifier: Apache-2.0
// Brings the Kinect's two streams together while they arrive, and its ticks to a time without end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/time.hpp"

namespace choreo::devices::freenect {

/// A picture as the library handed it over.
struct Shot {
  std::vector<std::uint8_t> bytes;
  std::uint32_t ticks = 0;    ///< Of the Kinect's clock of 60 MHz, which wraps after 71 s.
  std::uint32_t counter = 0;  ///< How many frame times its stream's first is ago: a gap is a picture that was lost.
  Nanoseconds arrival{0};     ///< On the host's monotonic clock.
};

/// Holds the newest colour and the newest depth picture until they belong together.
///
/// They do where their ticks are at most half a frame's time apart. Where the streams flow and none fits for half a
/// second, the clocks of the two cannot be trusted, and from then on their arrival decides.
/// @thread thread-bound
class Pairing {
 public:
  static constexpr Nanoseconds kWithin{16'666'667};
  static constexpr int kPatience = 15;  ///< Colour pictures.

  /// @param depth_bytes  of a picture; 0 where there is no depth, and colour is a pair by itself.
  Pairing(std::size_t colour_bytes, std::size_t depth_bytes);

  /// Copy a picture of the stated number of bytes; never allocate, never wait.
  /// @return whether `colour` and `depth` are a pair now, to be taken (the buffers may be swapped) before the next
  /// call.
  bool add_colour(const void* bytes, std::uint32_t ticks, Nanoseconds arrival) noexcept;
  bool add_depth(const void* bytes, std::uint32_t ticks, Nanoseconds arrival) noexcept;

  Shot colour;
  Shot depth;

  /// Whether arrival decides.
  [[nodiscard]] bool by_arrival() const { return by_arrival_; }

 private:
  bool complete() noexcept;
  [[nodiscard]] std::uint32_t next_number(std::uint32_t ticks, Nanoseconds arrival) const noexcept;

  bool with_depth_;
  bool colour_waits_ = false;
  bool depth_waits_ = false;
  bool by_arrival_ = false;
  bool colour_came_ = false;
  std::uint32_t last_ticks_ = 0, last_number_ = 0;  // Of the last colour picture.
  Nanoseconds last_arrival_{0};
  bool depth_came_ = false;
  int alone_ = 0;  // Colour pictures in a row whose partner did not come, though depth did.
};

/// Pairs that wait to be taken, the oldest first. Where there is no place left the oldest is lost.
/// @thread thread-bound
class PairQueue {
 public:
  /// @param places  at least 1.
  PairQueue(std::size_t places, std::size_t colour_bytes, std::size_t depth_bytes);

  [[nodiscard]] bool empty() const { return waiting_ == 0; }
  /// Both swap buffers, which must be of the sizes told; never allocate.
  void put(Shot& colour, Shot& depth) noexcept;
  /// @return whether there was one.
  bool take(Shot& colour, Shot& depth) noexcept;

 private:
  struct Pair {
    Shot colour, depth;
  };
  std::vector<Pair> pairs_;
  std::size_t first_ = 0;
  std::size_t waiting_ = 0;
};

/// The Kinect's time from its ticks; where they do not go on as the host's clock does, by more than `kMostOff` from one
/// picture to the next, the time goes on with the host's.
class TickClock {
 public:
  static constexpr Nanoseconds kMostOff = std::chrono::milliseconds(250);

  [[nodiscard]] Nanoseconds time(std::uint32_t ticks, Nanoseconds arrival);

 private:
  std::optional<Nanoseconds> time_;
  std::uint32_t ticks_ = 0;
  Nanoseconds arrival_{0};
};

}  // namespace choreo::devices::freenect
