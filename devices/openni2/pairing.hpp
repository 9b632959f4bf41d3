// SPDX-License-Identifier: Apache-2.0
// Which depth belongs to which picture.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "devices/openni2/protocol.hpp"

namespace choreo::devices::openni2 {

/// A picture in memory of our own.
struct Taken {
  Mode mode;
  std::uint32_t index = 0;
  std::uint64_t time_us = 0;
  std::vector<std::uint8_t> bytes;
};

/// One moment: what is seen, and its depth.
struct Moment {
  std::optional<Taken> video;
  std::optional<Taken> depth;

  [[nodiscard]] const Taken& leader() const { return video ? *video : *depth; }
};

/// Pairs two streams by their time stamps, which are of one clock.
///
/// The video leads: each of its pictures comes out once, in order, with the depth that is nearest in time, if that is
/// at most half a frame away; each depth is used once at most. A picture whose depth is not there is let go without it
/// as soon as the video is three frames further. Of one stream alone, every picture is a moment of its own.
class Pairing {
 public:
  /// @param streams  as Opened::streams.
  explicit Pairing(const std::vector<Mode>& streams);

  void add(Taken taken);
  /// The next moment that is complete; nothing where more must come first.
  [[nodiscard]] std::optional<Moment> next();
  /// Forgets what waits.
  void clear();
  /// No more will come: `next` gives the rest.
  void end() { ended_ = true; }

  /// Depths that had no picture to go with; those before the first one and at the end are nothing to speak of.
  [[nodiscard]] std::size_t unpaired_depths() const { return unpaired_; }

 private:
  [[nodiscard]] std::optional<Taken> depth_of(const Taken& video);
  [[nodiscard]] bool decided(const Taken& video) const;
  void drop_depth();

  bool both_;
  std::uint64_t period_us_;
  bool ended_ = false;
  bool begun_ = false;  // A picture has come out.
  std::deque<Taken> video_;
  std::deque<Taken> depth_;
  std::size_t unpaired_ = 0;
};

}  // namespace choreo::devices::openni2
