// SPDX-License-Identifier: Apache-2.0
#include "devices/openni2/mode_choice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "devices/fourcc.hpp"

namespace choreo::devices::openni2 {
namespace {

constexpr std::array kBestFirst = {kZ16, kRgb3, kYuyv, kUyvy, kMjpg, kGrey};

double area(std::uint32_t width, std::uint32_t height) { return double(width) * height; }

}  // namespace

std::optional<std::size_t> choose_mode(std::span<const Mode> modes, const ModeWish& wish) {
  const bool open = wish.width == 0;
  const auto width = open ? 640U : wish.width;
  const auto height = open ? 480U : wish.height;
  const double fps = wish.fps > 0 ? wish.fps : 30;
  std::optional<std::size_t> best;
  std::tuple<double, double, std::ptrdiff_t> least{};
  for (std::size_t k = 0; k < modes.size(); ++k) {
    const auto& mode = modes[k];
    const auto place = std::find(kBestFirst.begin(), kBestFirst.end(), mode.fourcc);
    const bool same = mode.width == width && mode.height == height;
    if (place == kBestFirst.end() || mode.width == 0 || mode.height == 0 || (wish.exactly && !same)) continue;
    // Of the same area, the same shape is nearer.
    const double far = same ? 0 : 1e-6 + std::abs(std::log(area(mode.width, mode.height) / area(width, height)));
    const std::tuple rank{far, std::abs(mode.fps - fps), place - kBestFirst.begin()};
    if (!best || rank < least) {
      best = k;
      least = rank;
    }
  }
  return best;
}

}  // namespace choreo::devices::openni2
