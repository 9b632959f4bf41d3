// SPDX-License-Identifier: Apache-2.0
// Which pixels around a face are taken for the head and the neck, and so for no arm.
#pragma once

#include <cmath>

namespace choreo::vision {

// In face widths, from the face's centre, y down. The head with ears and crown; the neck down to its pit, and the
// corner of a neckline under it.
inline constexpr double kHeadHalfWidth = 0.72;
inline constexpr double kHeadHalfHeight = 0.85;
inline constexpr double kHeadAbove = 0.1;
inline constexpr double kNeckHalfWidth = 0.5;
inline constexpr double kNeckPit = 1.25;
inline constexpr double kNecklineEnd = 1.6;

/// The half width of the head at a height; below 0 outside.
[[nodiscard]] inline double head_half_width(double y) {
  const double t = (y + kHeadAbove) / kHeadHalfHeight;
  return std::abs(t) < 1 ? kHeadHalfWidth * std::sqrt(1 - t * t) : -1;
}

/// Likewise of the neck.
[[nodiscard]] inline double neck_half_width(double y) {
  if (y < 0 || y >= kNecklineEnd) return -1;
  return y < kNeckPit ? kNeckHalfWidth : kNeckHalfWidth * (kNecklineEnd - y) / (kNecklineEnd - kNeckPit);
}

/// Whether a point is on head or neck.
[[nodiscard]] inline bool in_face_region(double x, double y) {
  return std::abs(x) <= std::fmax(head_half_width(y), neck_half_width(y));
}

}  // namespace choreo::vision
