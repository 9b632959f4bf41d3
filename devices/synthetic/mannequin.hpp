// SPDX-License-Identifier: Apache-2.0
// Draws the figure with its clothes, hair and face.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "body/figure.hpp"
#include "devices/synthetic/brush.hpp"
#include "devices/synthetic/look.hpp"
#include "devices/synthetic/room.hpp"

namespace choreo::devices::synthetic {

/// Marks under which the brush draws (see Brush::mark); all else is 1.
inline constexpr unsigned char kFaceMark = 2;
inline constexpr std::array<unsigned char, 2> kBareArmMark = {3, 4};  ///< By body::Side: skin of hand and arm.

/// Lays the brush over the figure's part of the picture and draws the figure, the far parts first.
/// @param shift  pixels by which the camera displaces everything.
/// @return false where nothing of the figure can be inside the picture; the brush is then untouched.
bool draw_figure(Brush& brush, const body::Pose& pose, const Look& look, const Stage& stage, cv::Point2d shift);

/// Where the face is (see face_box), in picture coordinates: empty where it is turned away or where less than half of
/// it is to be seen, because something is before it or because it is outside the picture.
/// @param brush  on which the figure was drawn with the same parameters.
[[nodiscard]] cv::Rect2d visible_face(const Brush& brush, const body::Pose& pose, const Stage& stage,
                                      cv::Point2d shift);

/// How much the figure darkens the floor at a pixel: up to 9 grey levels around feet that stand on it.
class FloorShadow {
 public:
  FloorShadow(const body::Pose& pose, const Stage& stage, cv::Point2d shift);

  /// Picture rows that the shadow can reach: [first, last).
  [[nodiscard]] std::pair<int, int> rows() const { return rows_; }
  /// Subtracts the shadow from one row of the picture, three values a pixel, in 1/32 grey levels.
  void darken(int y, std::vector<int>& row) const;

 private:
  struct Patch {
    cv::Point2d centre;
    double half_width, half_height, depth;
  };
  std::array<Patch, 2> patches_{};
  std::pair<int, int> rows_{0, 0};
};

}  // namespace choreo::devices::synthetic
