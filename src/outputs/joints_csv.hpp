// SPDX-License-Identifier: Apache-2.0
// The joints of the person in every frame, as a table.
//
// Columns; a field is empty where nobody was seen. Pixels are those of the working resolution, y down.
//   frame, time_s       the source's frames counted from 1; since its first frame
//   looked              1 where the network looked at this frame; 0 where what follows is between two looks
//   score               how likely somebody is there, 0 to 1
// then for each point of vision::kPersonPointNames, such as left_wrist:
//   left_wrist_x_px, left_wrist_y_px
//   left_wrist_visibility   how likely nothing hides it, 0 to 1
//   left_wrist_x_m, left_wrist_y_m, left_wrist_z_m   from the middle of the hips: right, down, away from the camera
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "vision/person/person.hpp"

namespace choreo::outputs {

/// A person's joints, small enough to be kept for hours.
struct PersonJoints {
  using Point = std::array<float, 6>;  ///< Pixels, visibility, metres.

  float score = 0;
  std::array<Point, vision::kPersonPoints> points{};
};

/// What a look told.
struct JointsLook {
  double time_s = 0;                   ///< Of the frame that was looked at.
  std::optional<PersonJoints> person;  ///< Nothing: nobody was there.

  JointsLook(double time, const vision::PersonLook* look);  ///< Null: nobody was there.
};

/// One frame.
struct JointsFrame {
  std::uint64_t frame = 0;  ///< The source's frames counted from 1.
  double time_s = 0;        ///< Since the source's first frame.
};

/// A header line and a line a frame, comma separated, as RFC 4180 with \n. Between two looks that follow each other and
/// both saw somebody the numbers are linear in time.
/// @param frames, looks  each in order of time.
[[nodiscard]] std::string joints_csv(std::span<const JointsFrame> frames, std::span<const JointsLook> looks);

}  // namespace choreo::outputs
