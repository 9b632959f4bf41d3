// SPDX-License-Identifier: Apache-2.0
// What the performer and the room look like: builds, tones, clothes, walls, chosen by the seed or by name.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include <opencv2/core.hpp>

#include "body/figure.hpp"
#include "devices/synthetic/scene.hpp"

namespace choreo::devices::synthetic {

enum class HairStyle { kShort, kBob, kBun };

/// Colours are blue green red, 0 to 255, in full light.
struct Look {
  body::Build build = body::Build::kMedium;
  HairStyle hair_style = HairStyle::kShort;
  cv::Vec3f skin, hair, shirt, trousers, shoes;
  cv::Vec3f wall, panel, floor;
  Sleeves sleeves = Sleeves::kHalf;
  bool flags = false;  ///< One in each hand.
};

/// A colour written red green blue, as one reads colours elsewhere.
[[nodiscard]] inline cv::Vec3f rgb(int red, int green, int blue) {
  return {static_cast<float>(blue), static_cast<float>(green), static_cast<float>(red)};
}

/// The six tones that `skin=` names, from very light to dark.
[[nodiscard]] std::span<const cv::Vec3f> skin_tones();

/// Names for `build=`, `skin=` and `clothes=`; the first, "auto", leaves the choice to the seed.
[[nodiscard]] std::span<const std::string> build_names();
[[nodiscard]] std::span<const std::string> skin_names();
[[nodiscard]] std::span<const std::string> clothes_names();

/// 0.299 |dR| + 0.587 |dG| + 0.114 |dB| of two colours.
[[nodiscard]] double colour_distance(const cv::Vec3f& a, const cv::Vec3f& b);

/// Chooses everything. Shirt and hair keep at least 35 grey levels from wall and panel in any light, trousers and shoes
/// also from the floor; with clothes "wall", shirt and trousers are within 12 of the wall instead, with "near-wall"
/// they have its hue and are 15 % darker.
/// @param build, skin, clothes  one of the names above.
[[nodiscard]] Look choose_look(std::uint64_t seed, const std::string& build, const std::string& skin,
                               const std::string& clothes);

}  // namespace choreo::devices::synthetic
