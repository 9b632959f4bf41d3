// SPDX-License-Identifier: Apache-2.0
#include "devices/synthetic/scene.hpp"

#include <algorithm>
#include <array>

namespace choreo::devices::synthetic {
namespace {

std::size_t index_of(std::span<const std::string> names, const std::string& name) {
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

}  // namespace

std::span<const std::string> sleeves_names() {
  static const std::array<std::string, 3> kNames = {"half", "long", "none"};
  return kNames;
}

std::span<const std::string> room_names() {
  static const std::array<std::string, 3> kNames = {"plain", "cluttered", "wooden"};
  return kNames;
}

std::span<const std::string> light_names() {
  static const std::array<std::string, 4> kNames = {"neutral", "warm", "dim", "cool"};
  return kNames;
}

Sleeves sleeves_named(const std::string& name) {
  static constexpr std::array kKinds = {Sleeves::kHalf, Sleeves::kLong, Sleeves::kNone};
  return kKinds.at(index_of(sleeves_names(), name));
}

Furniture furniture_named(const std::string& name) {
  static constexpr std::array kKinds = {Furniture::kPlain, Furniture::kCluttered, Furniture::kWooden};
  return kKinds.at(index_of(room_names(), name));
}

cv::Vec3d light_named(const std::string& name) {
  // An incandescent lamp, a dimmed one of no colour, an overcast sky: before a camera that keeps its white balance.
  static const std::array<cv::Vec3d, 4> kGains = {
      {{1, 1, 1}, {0.60, 0.88, 1.06}, {0.45, 0.45, 0.45}, {1.16, 0.94, 0.76}}};
  return kGains.at(index_of(light_names(), name));
}

}  // namespace choreo::devices::synthetic
