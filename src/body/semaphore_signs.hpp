// SPDX-License-Identifier: Apache-2.0
// The flag semaphore alphabet as arm positions and as poses of the figure.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "body/figure.hpp"

namespace choreo::body {

/// A sign: where each arm points. Positions count in steps of 45 degrees, 0 down, 1 to 3 on the signaller's right, 4
/// up, 5 to 7 on the left.
struct SemaphoreSign {
  std::string_view name;  ///< "A" to "Z", "REST", "NUMERALS", "CANCEL".
  int left = 0;           ///< Position of the signaller's left arm, 0 to 7.
  int right = 0;
};

/// All 29 signs, A to Z first. An arm reaches across the body only where both point to one side (H, I, O, W, X, Z).
[[nodiscard]] std::span<const SemaphoreSign> semaphore_signs();

/// The sign of that name; nothing where there is none. Upper case.
[[nodiscard]] std::optional<SemaphoreSign> semaphore(std::string_view name);

/// Its place in semaphore_signs(). @param name  of one of them.
[[nodiscard]] std::size_t place_of(std::string_view name);

/// The sign that shows the same two positions, whichever arm is where; nothing where no sign does.
[[nodiscard]] std::optional<SemaphoreSign> semaphore_at(int one_arm, int other_arm);

/// Where the mirror shows a position: 8 - k, and 0 for 0.
[[nodiscard]] constexpr int mirrored_position(int position) { return (8 - position) % 8; }

/// The figure showing a sign with straight arms; feet as in standing.
[[nodiscard]] Pose semaphore_pose(const SemaphoreSign& sign);

}  // namespace choreo::body
