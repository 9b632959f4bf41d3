// SPDX-License-Identifier: Apache-2.0
#include "devices/synthetic/look.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "devices/synthetic/chance.hpp"

namespace choreo::devices::synthetic {
namespace {

struct Room {
  cv::Vec3f wall, panel, floor;
};

const std::array<Room, 6>& rooms() {
  static const std::array<Room, 6> kRooms = {{
      {rgb(178, 187, 190), rgb(164, 175, 180), rgb(150, 132, 112)},  // cool grey
      {rgb(172, 186, 168), rgb(158, 174, 155), rgb(156, 138, 114)},  // sage
      {rgb(168, 184, 198), rgb(154, 171, 187), rgb(146, 131, 116)},  // pale blue
      {rgb(188, 186, 180), rgb(174, 172, 166), rgb(150, 130, 106)},  // stone
      {rgb(182, 178, 192), rgb(167, 163, 179), rgb(148, 132, 118)},  // lilac
      {rgb(78, 94, 104), rgb(172, 176, 174), rgb(150, 132, 112)},    // slate, light panelling
  }};
  return kRooms;
}

struct Garment {
  std::string name;
  cv::Vec3f colour;
};

const std::vector<Garment>& shirts() {
  static const std::vector<Garment> kShirts = {
      {"red", rgb(178, 42, 46)},     {"blue", rgb(36, 66, 132)},   {"green", rgb(28, 98, 72)},
      {"dark", rgb(44, 46, 56)},     {"orange", rgb(206, 92, 28)}, {"violet", rgb(96, 48, 112)},
      {"petrol", rgb(16, 92, 108)},  {"berry", rgb(146, 32, 84)},  {"white", rgb(250, 248, 240)},
      {"yellow", rgb(238, 190, 48)},
  };
  return kShirts;
}

const std::vector<cv::Vec3f>& trousers() {
  static const std::vector<cv::Vec3f> kTrousers = {rgb(40, 46, 66), rgb(52, 50, 50), rgb(34, 58, 62), rgb(66, 42, 40)};
  return kTrousers;
}

const std::vector<cv::Vec3f>& skins() {
  static const std::vector<cv::Vec3f> kSkins = {rgb(255, 224, 202), rgb(244, 205, 176), rgb(226, 178, 142),
                                                rgb(196, 142, 104), rgb(148, 98, 68),   rgb(98, 64, 46)};
  return kSkins;
}

const std::vector<cv::Vec3f>& hairs() {
  static const std::vector<cv::Vec3f> kHairs = {rgb(40, 30, 26), rgb(74, 48, 32), rgb(108, 66, 36), rgb(128, 58, 28)};
  return kHairs;
}

std::size_t index_of(std::span<const std::string> names, const std::string& name) {
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

// The least distance from any of the backgrounds over the light that falls on round cloth (see brush.cpp).
double least_distance(const cv::Vec3f& colour, std::initializer_list<cv::Vec3f> backgrounds) {
  double least = 255;
  for (double light = 0.6; light <= 1.06; light += 0.05) {
    for (const auto& b : backgrounds) least = std::min(least, colour_distance(colour * light, b));
  }
  return least;
}

}  // namespace

std::span<const cv::Vec3f> skin_tones() { return skins(); }

std::span<const std::string> build_names() {
  static const std::vector<std::string> kNames = {"auto", "slender", "medium", "stout"};
  return kNames;
}

std::span<const std::string> skin_names() {
  static const std::vector<std::string> kNames = {"auto", "very-light", "light", "medium", "tan", "brown", "dark"};
  return kNames;
}

std::span<const std::string> clothes_names() {
  static const auto kNames = [] {
    std::vector<std::string> names = {"auto", "wall", "near-wall"};
    for (const auto& shirt : shirts()) names.push_back(shirt.name);
    return names;
  }();
  return kNames;
}

double colour_distance(const cv::Vec3f& a, const cv::Vec3f& b) {
  return 0.114 * std::abs(a[0] - b[0]) + 0.587 * std::abs(a[1] - b[1]) + 0.299 * std::abs(a[2] - b[2]);
}

Look choose_look(std::uint64_t seed, const std::string& build, const std::string& skin, const std::string& clothes) {
  // One stream of chance for each choice, so that setting one by name does not change the others.
  const auto pick = [&](std::uint64_t what, std::size_t count) {
    return static_cast<std::size_t>(mixed(seed, 100 + what) % count);
  };
  Look look;
  look.build = static_cast<body::Build>(build == "auto" ? pick(0, 3) : index_of(build_names(), build) - 1);
  look.skin = skins()[skin == "auto" ? pick(1, skins().size()) : index_of(skin_names(), skin) - 1];
  look.hair_style = static_cast<HairStyle>(pick(2, 3));

  // A wall from which the skin stands out too, if there is one: the farthest of those tried wins otherwise.
  const auto first_room = pick(3, rooms().size());
  double best = -1;
  for (std::size_t i = 0; i < rooms().size(); ++i) {
    const auto& room = rooms()[(first_room + i) % rooms().size()];
    const double distance = least_distance(look.skin, {room.wall});
    if (distance > best) {
      best = distance;
      look.wall = room.wall;
      look.panel = room.panel;
      look.floor = room.floor;
    }
    if (best >= 25) break;
  }

  constexpr double kFarEnough = 35;
  const auto choose = [&](std::uint64_t what, const std::vector<cv::Vec3f>& from,
                          std::initializer_list<cv::Vec3f> backgrounds) {
    // Of those that stand out, the one that chance ranks first.
    const cv::Vec3f* best_colour = nullptr;
    std::uint64_t best_rank = 0;
    for (std::size_t i = 0; i < from.size(); ++i) {
      const auto rank = mixed(seed, 100 + what, 1 + i);
      if (least_distance(from[i], backgrounds) < kFarEnough) continue;
      if (best_colour == nullptr || rank > best_rank) {
        best_colour = &from[i];
        best_rank = rank;
      }
    }
    return best_colour != nullptr ? *best_colour : from.front();
  };
  // Red and light brown hair go with light skin only.
  const bool dark_skin = look.skin[2] < 170;
  look.hair = choose(4, {hairs().begin(), hairs().begin() + (dark_skin ? 2 : 4)}, {look.wall});
  look.shoes = rgb(38, 34, 36);
  look.trousers = choose(5, trousers(), {look.wall, look.panel, look.floor});
  if (clothes == "wall") {
    look.shirt = look.wall * 1.06F;
    look.trousers = look.panel * 1.04F;
  } else if (clothes == "near-wall") {
    look.shirt = look.wall * 0.85F;
    look.trousers = look.panel * 0.85F;
  } else if (clothes == "auto") {
    std::vector<cv::Vec3f> colours;
    for (const auto& shirt : shirts()) colours.push_back(shirt.colour);
    look.shirt = choose(6, colours, {look.wall, look.panel});
  } else {
    const auto named = [&](const auto& shirt) { return shirt.name == clothes; };
    look.shirt = std::find_if(shirts().begin(), shirts().end(), named)->colour;
  }
  return look;
}

}  // namespace choreo::devices::synthetic
