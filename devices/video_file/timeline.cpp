// SPDX-License-Identifier: Apache-2.0
#include "devices/video_file/timeline.hpp"

#include <algorithm>

namespace choreo::devices {

Timeline::Timeline(Nanoseconds nominal, Nanoseconds smallest)
    : nominal_(nominal), smallest_(std::max(smallest, Nanoseconds(1))) {
  nominal_ = std::max(nominal_, smallest_);
}

Nanoseconds Timeline::next(std::optional<Nanoseconds> stamp) {
  Nanoseconds time{0};
  if (stamp && (!previous_ || *stamp > *previous_)) {
    time = *stamp;
  } else {
    ++mended_;
    if (previous_) {
      auto step = nominal_;
      if (stamp && previous_stamp_) {
        if (*stamp > *previous_stamp_) {
          step = *stamp - *previous_stamp_;
        } else if (*stamp == *previous_stamp_) {
          step = smallest_;
        } else {
          step = std::max(nominal_ / 2, smallest_);
        }
      } else if (stamp) {
        step = smallest_;
      }
      time = *previous_ + step;
    }
  }
  previous_ = time;
  previous_stamp_ = stamp;
  return time;
}

}  // namespace choreo::devices
