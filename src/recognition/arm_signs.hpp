// SPDX-License-Identifier: Apache-2.0
// Which sign of semaphore two arms show, by where the forearms point.
#pragma once

#include <array>
#include <string_view>

#include "body/arm_poses.hpp"
#include "body/semaphore_signs.hpp"
#include "recognition/semaphore_templates.hpp"

namespace choreo::recognition {

/// What two arms show.
struct ArmSigns {
  std::string_view best;     ///< The likeliest sign of body::semaphore_signs() but REST; never empty.
  double probability = 0;    ///< Of it, [0, 1].
  std::string_view next;     ///< The next likely but REST; never empty.
  double rest = 0;           ///< Probability of REST.
  double none = 1;           ///< Of its being no sign at all.
  std::array<double, kSemaphoreSigns> of{};  ///< Probability of every sign, by its place in body::semaphore_signs().
  bool arms_hidden = false;  ///< An arm is hardly seen or not at all: nothing can be told.
};

/// Bayes' rule, with one half for no sign and the other half for all signs alike.
///
/// Who shows a sign points each forearm at its position, off by a standard deviation of 11 degrees and what looks
/// differ by, and bends an elbow by one of 22 degrees, of 45 where the arm reaches across; who does not points them
/// anywhere and bends them by anything up to 150 degrees. An arm that is much shorter in the picture than an arm is,
/// since it points at the camera or away, or that is hidden, tells less for a sign. An arm reaches across the body
/// where both point to one side (H, I, O, W, X, Z), and then either may; elsewhere each keeps to its own side.
/// @thread reentrant
[[nodiscard]] ArmSigns arm_signs(const body::ArmPoses& arms);

}  // namespace choreo::recognition
