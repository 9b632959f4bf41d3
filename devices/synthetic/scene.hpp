// SPDX-License-Identifier: Apache-2.0
// What a performance is filmed in: furniture, light, sleeves and where the camera stands, chosen by name.
#pragma once

#include <span>
#include <string>

#include <opencv2/core.hpp>

namespace choreo::devices::synthetic {

enum class Sleeves {
  kLong,  ///< To the wrist.
  kHalf,  ///< To the elbow: the forearm is bare.
  kNone,  ///< Bare from the shoulder.
};

enum class Furniture {
  kPlain,      ///< A panelled wall with two small pictures.
  kCluttered,  ///< Shelves of books, a window, a plant, pictures: strong edges and colours.
  kWooden,     ///< Cupboard, door, table and curtain in skin's own hues, behind where arms point.
};

/// The room that is painted.
struct Scene {
  Furniture furniture = Furniture::kPlain;
  bool poster = false;  ///< A painted face on the wall.
};

/// Displacement of the picture's content by a camera that stands elsewhere: p -> centre + zoom (p - centre) + shift.
struct CameraPan {
  double dx = 0;    ///< Pixels to the right, -64 to 64.
  double dy = 0;    ///< Pixels down.
  double zoom = 1;  ///< 0.9 to 1.1.

  [[nodiscard]] bool none() const { return dx == 0 && dy == 0 && zoom == 1; }
};

/// Names for `sleeves=`, `room=` and `light=`; the first is what a performance has by itself.
[[nodiscard]] std::span<const std::string> sleeves_names();
[[nodiscard]] std::span<const std::string> room_names();
[[nodiscard]] std::span<const std::string> light_names();

/// The thing of that name, which must be one of the names above.
[[nodiscard]] Sleeves sleeves_named(const std::string& name);
[[nodiscard]] Furniture furniture_named(const std::string& name);

/// Factors on blue, green and red. Under "warm" light skin looks orange, under "cool" greyish blue; "dim" is 0.45.
[[nodiscard]] cv::Vec3d light_named(const std::string& name);

}  // namespace choreo::devices::synthetic
