// SPDX-License-Identifier: Apache-2.0
// What stands before the tests' own OpenNI2 camera: the pattern, or pictures from a file.
#pragma once

#include <algorithm>
#include <fstream>
#include <vector>

#include "support/oni_pattern.hpp"

namespace choreo::test {

/// The file: width, height and number of pictures as int, then per picture the colours and the depths.
class OniScene {
 public:
  /// @param file  null: the pattern.
  explicit OniScene(const char* file) {
    if (file == nullptr) return;
    std::ifstream in(file, std::ios::binary);
    int count = 0;
    for (int* number : {&width_, &height_, &count}) in.read(reinterpret_cast<char*>(number), sizeof *number);
    pictures_.resize(static_cast<std::size_t>(count));
    const auto read = [&](auto& pixels) {
      pixels.resize(static_cast<std::size_t>(width_ * height_));
      in.read(reinterpret_cast<char*>(pixels.data()),
              static_cast<std::streamsize>(pixels.size() * sizeof pixels.front()));
    };
    for (auto& [colours, depths] : pictures_) {
      read(colours);
      read(depths);
    }
  }

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }

  void film(int k, OniRgb* out) const {
    if (!pictures_.empty()) {
      std::ranges::copy(at(k).colours, out);
      return;
    }
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) *out++ = oni_colour(k, x, y);
    }
  }
  void film(int k, std::uint16_t* out) const {
    if (!pictures_.empty()) {
      std::ranges::copy(at(k).depths, out);
      return;
    }
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) *out++ = oni_depth(k, x, y);
    }
  }

 private:
  struct Picture {
    std::vector<OniRgb> colours;
    std::vector<std::uint16_t> depths;
  };
  [[nodiscard]] const Picture& at(int k) const { return pictures_[static_cast<std::size_t>(k) % pictures_.size()]; }

  int width_ = kOniWidth, height_ = kOniHeight;
  std::vector<Picture> pictures_;
};

}  // namespace choreo::test
