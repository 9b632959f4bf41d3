// SPDX-License-Identifier: Apache-2.0
// The settings of reading semaphore.
#pragma once

namespace choreo::recognition {

/// What is a sign and what is none. Similarities are Z of particle states, and still_widths_s, too, is for these alone.
struct SemaphoreOptions {
  bool mirrored = false;  ///< The picture is a mirror image, as a selfie camera shows it.

  double least_similarity = 0.92;  ///< Z from which a posture may be a sign, 0.5 to 0.999.
  double margin = 0.006;           ///< By how much Z must exceed that of every other sign, 0 to 0.5.
  double hysteresis = 0.06;        ///< How far below `least_similarity` a sign that is held may fall, 0 to 0.5.

  double hold_s = 0.5;          ///< Seconds for which a sign must be held still, 0.05 to 5.
  double still_widths_s = 0.4;  ///< Speed of an arm's middle against the face up to which it counts as still, face
                                ///< widths a second, 0.05 to 50.
  double still_degrees_s = 4;   ///< Where the person network sees the arms: how fast they may turn and yet count as
                                ///< still, degrees a second, 0.1 to 500.
  double bridge_s = 0.4;        ///< Seconds without a state that do not end a sign, 0 to 5.
  double word_gap = 0.65;       ///< A REST of so many letters' length is a space, 0.05 to 20.

  /// @throws Error (usage) where a value is out of its range.
  void validate() const;
};

}  // namespace choreo::recognition
