// SPDX-License-Identifier: Apache-2.0
#include "outputs/frames_csv.hpp"

#include <iterator>

#include <fmt/format.h>

namespace choreo::outputs {

std::string frames_csv(std::span<const FrameRow> rows) {
  std::string csv =
      "frame,time_s,body,area_px,centroid_x_px,centroid_y_px,box_x_px,box_y_px,box_width_px,box_height_px,"
      "quantity_of_motion,contraction,zstar_tt\n";
  for (const auto& r : rows) {
    auto out = std::back_inserter(csv);
    if (!r.body) {
      fmt::format_to(out, "{},{:.6f},0,nan,nan,nan,nan,nan,nan,nan,nan,nan,nan\n", r.frame, r.time_s);
      continue;
    }
    fmt::format_to(out, "{},{:.6f},1,{},{:.3f},{:.3f},{},{},{},{},{:.6f},{:.6f},{:.6f}\n", r.frame, r.time_s, r.area_px,
                   r.centroid_px.x, r.centroid_px.y, r.box_px.x, r.box_px.y, r.box_px.width, r.box_px.height,
                   r.quantity_of_motion, r.contraction, r.zstar_tt);
  }
  return csv;
}

}  // namespace choreo::outputs
