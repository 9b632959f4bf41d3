// SPDX-License-Identifier: Apache-2.0
// Photographs of a synthetic signaller: off centre in a room of skin-coloured wood, the camera and the light a little
// different from one to the next.
#pragma once

#include <string>
#include <vector>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "devices/synthetic/performer.hpp"

namespace choreo::test {

struct Still {
  std::string letter;
  cv::Mat bgr;
  cv::Rect2d face;
};

/// One picture a letter. The camera is moved by up to 12 px and 1 %, the exposure by 15 %.
inline std::vector<Still> signaller_stills(const std::string& letters, std::uint64_t seed,
                                           devices::synthetic::PerformerSettings settings = {},
                                           const char* room = "wooden") {
  settings.size = {600, 450};
  settings.fps = 10;
  settings.empty = 0;
  settings.seed = seed;
  settings.room = room;
  settings.place = (seed % 2 != 0 ? 1 : -1) * (0.08 + 0.02 * double(seed % 5));
  cv::RNG random(seed * 7919 + 1);
  std::vector<Still> out;
  for (const char letter : letters) {
    settings.text = std::string(1, letter);
    settings.pan = {random.uniform(-12.0, 12.0), random.uniform(-12.0, 12.0), random.uniform(0.99, 1.01)};
    settings.exposure = random.uniform(0.85, 1.15);
    const devices::synthetic::Performer performer("semaphore", settings);
    auto shown = performer.perform(21 + random.uniform(-4, 5));  // The letter is held from 0.75 to 3.5 s.
    out.push_back({settings.text, shown.bgr, shown.face});
  }
  return out;
}

}  // namespace choreo::test
