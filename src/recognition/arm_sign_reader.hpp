// SPDX-License-Identifier: Apache-2.0
// From looks at where arms point to signs of semaphore with their times.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "body/arm_poses.hpp"
#include "recognition/arm_signs.hpp"
#include "recognition/held_sign.hpp"
#include "recognition/semaphore_movement.hpp"
#include "recognition/semaphore_options.hpp"

namespace choreo::recognition {

/// Reads signs that are held. A sign is held where for `hold_s` and three looks upper arms and forearms turned no
/// faster than `still_degrees_s` and what looks differ by, and the mean of these looks shows it with a probability of
/// 0.7
/// (`arm_signs`): it is known with the look that completes the time, and began with the first of them. A look does not
/// count that is unlike the two before it and the one after it while these are alike. A sign ends when for 0.12 seconds
/// the arms have been elsewhere, were not seen for `bridge_s`, or no look came for a second (nor for `bridge_s`). One
/// held sign is one sign however long; the same again needs another posture or a pause in between. Who holds a sign's
/// posture does show that sign.
///
/// Depends on times and arms alone. From 1 to 240 looks a second; movements need ten.
/// @thread thread-bound
class ArmSignReader {
 public:
  /// @throws Error (usage) by options.validate(). `mirrored` is not looked at: arms are the signaller's own.
  explicit ArmSignReader(const SemaphoreOptions& options = {});

  /// @param time_s  of the picture that was looked at, increasing; a look that is not later than the last does not
  ///   count.
  /// @param arms    nothing where nobody is seen.
  SemaphoreStep add(double time_s, const std::optional<body::ArmPoses>& arms);

  /// What the last look said: between looks nothing is new.
  [[nodiscard]] SemaphoreStep last() const { return told({}); }

  /// Ends what is being held, at the stream's end. The reader is then as new.
  std::vector<HeldSign> finish();

 private:
  struct Look {
    double time_s;
    body::ArmPoses arms;
  };
  using Looks = std::deque<Look>;

  void drop_stray();
  [[nodiscard]] SemaphoreStep told(SemaphoreStep step) const;
  void lapse(double time_s, bool seen, SemaphoreStep& step);
  void follow(double time_s, const ArmSigns& now, SemaphoreStep& step);
  void end_hold(SemaphoreStep& step);
  [[nodiscard]] std::optional<Looks::const_iterator> long_enough() const;
  [[nodiscard]] bool still(Looks::const_iterator from) const;
  [[nodiscard]] static body::ArmPoses mean_of(Looks::const_iterator from, Looks::const_iterator to);

  SemaphoreOptions options_;
  MovementDetector movements_;
  Looks looks_;                      // As many as `hold_s` needs.
  std::optional<double> last_;       // time of the last call
  std::optional<double> last_arms_;  // time of the last arms
  std::optional<SignHold> held_;
  std::optional<double> left_;  // when the arms left the sign that is held
  SignReading now_;
};

}  // namespace choreo::recognition
