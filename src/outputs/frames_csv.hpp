// SPDX-License-Identifier: Apache-2.0
// What is known of every frame, as a table.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include <opencv2/core/types.hpp>

namespace choreo::outputs {

/// One frame. Lengths in pixels of the working resolution.
struct FrameRow {
  std::uint64_t frame = 0;  ///< The source's frames counted from 1.
  double time_s = 0;        ///< Since the source's first frame.
  bool body = false;        ///< Without a body, everything below is written as nan.
  std::int64_t area_px = 0;
  cv::Point2d centroid_px;
  cv::Rect box_px;
  double quantity_of_motion = 0;
  double contraction = 0;
  float zstar_tt = 0;  ///< Z*(t, t): how mirror-symmetric the pose is.
};

/// A header line and a line a frame, comma separated, as RFC 4180 with \n.
[[nodiscard]] std::string frames_csv(std::span<const FrameRow> rows);

}  // namespace choreo::outputs
