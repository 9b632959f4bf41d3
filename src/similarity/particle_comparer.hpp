// SPDX-License-Identifier: Apache-2.0
// Z and Z* of particle states.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "body/particle_state.hpp"
#include "similarity/comparer.hpp"
#include "similarity/particle_columns.hpp"

namespace choreo::similarity {

class ParticleComparer final : public Comparer {
 public:
  /// @param states  one a frame, empty where a frame has no two-arm state; may be destroyed afterwards.
  explicit ParticleComparer(std::span<const std::optional<body::ParticleState>> states);

  [[nodiscard]] std::size_t size() const override { return columns_.capacity(); }
  void compare(Range rows, Range cols, MatrixView<float> z, MatrixView<float> zstar) const override;

  [[nodiscard]] std::size_t bytes() const { return columns_.bytes(); }  ///< Held for comparing.

 private:
  ParticleColumns columns_;
};

}  // namespace choreo::similarity
