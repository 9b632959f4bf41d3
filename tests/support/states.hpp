// SPDX-License-Identifier: Apache-2.0
// Sequences of silhouettes with gaps, and the pair of matrices that comes of them.
#pragma once

#include <bit>
#include <cstdint>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include "body/mask_state.hpp"
#include "core/matrix_view.hpp"
#include "support/drawn_masks.hpp"

namespace choreo::test {

using States = std::vector<std::unique_ptr<const body::MaskState>>;

inline std::unique_ptr<const body::MaskState> state_of(const cv::Mat& mask) {
  return std::make_unique<const body::MaskState>(mask);
}

/// n states of random shape and size, every seventh a gap.
inline States random_states(std::size_t n, std::size_t seed) {
  std::mt19937 random(static_cast<std::mt19937::result_type>(seed));
  States states;
  for (std::size_t k = 0; k < n; ++k) {
    const cv::Size size(2 + int(random() % 30), 1 + int(random() % 40));
    const double density = 0.05 + 0.9 * double(random() % 100) / 100;
    const auto mask = random_mask(random, size, density);
    states.push_back(k % 7 == 5 ? nullptr : state_of(mask));
  }
  return states;
}

/// What a history gives for one state.
struct HistoryRow {
  std::vector<float> z;
  std::vector<float> zstar;
};

inline constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// Equal as bits, so that NaN equals NaN.
inline bool same_bits(float a, float b) { return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b); }

/// Z and Z* of n states, at first filled with a value that no similarity has.
struct Matrices {
  std::size_t n;
  std::vector<float> z;
  std::vector<float> zstar;

  explicit Matrices(std::size_t count) : n(count), z(count * count, -1.0F), zstar(count * count, -1.0F) {}
  [[nodiscard]] MatrixView<float> z_view() { return {z.data(), n, n}; }
  [[nodiscard]] MatrixView<float> zstar_view() { return {zstar.data(), n, n}; }
  [[nodiscard]] float z_at(std::size_t i, std::size_t j) const { return z[i * n + j]; }
  [[nodiscard]] float zstar_at(std::size_t i, std::size_t j) const { return zstar[i * n + j]; }

  friend bool operator==(const Matrices& a, const Matrices& b) {
    if (a.n != b.n) return false;
    for (std::size_t k = 0; k < a.z.size(); ++k) {
      if (!same_bits(a.z[k], b.z[k]) || !same_bits(a.zstar[k], b.zstar[k])) return false;
    }
    return true;
  }
};

}  // namespace choreo::test
