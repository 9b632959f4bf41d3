// SPDX-License-Identifier: Apache-2.0
// From a stream of particle states to signs of semaphore with their times.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "recognition/held_sign.hpp"
#include "recognition/semaphore_movement.hpp"
#include "recognition/semaphore_templates.hpp"

namespace choreo::recognition {

/// Reads signs that are held: a sign begins when for `hold_s` the arms are still and one sign leads; it ends when for
/// 0.12 seconds they have been elsewhere, were not seen for `bridge_s`, or no frame came for a second (nor for
/// `bridge_s`). Time in which there is no state (one arm hidden, no arm, no face) shows no sign. A state whose arms are
/// joined is compared with the figure whose arms are: folded hands are REST, and arms that meet while both point to one
/// side are a letter (H, I, O, W, X, Z). One held sign is one sign however long; the same again needs another posture
/// or a pause in between. A dancer who holds a sign's posture for `hold_s` does show that sign.
///
/// Depends on times and states alone. Frame rates from 10 to 240 a second. Down to 1 a second signs that are held for
/// three frames are read; movements are then too quick.
/// @thread thread-bound
class SemaphoreReader {
 public:
  /// @param bounds  those of the states that will come. @throws Error (usage) by options.validate() and
  ///   bounds.validate().
  explicit SemaphoreReader(const SemaphoreOptions& options = {}, const body::ParticleBounds& bounds = {});

  /// @param time_s  increasing; a state that is not later than the last is not looked at.
  /// @param state   nothing where two arms and a face were not seen.
  /// @cost  two passes over the templates, about 6000 in all; allocates where a sign ends.
  SemaphoreStep add(double time_s, const std::optional<body::ParticleState>& state);

  /// Ends what is being held, at the stream's end. The reader is then as new.
  std::vector<HeldSign> finish();

 private:
  struct Sample {
    double time_s;
    UnitPsi psi;
    bool joined;
    std::array<Eigen::Vector2d, 2> arm;  // from the face, in face widths
  };

  [[nodiscard]] bool still() const;
  [[nodiscard]] SignMatch match(const body::ParticleState& newest) const;
  void follow(double time_s, const SignMatch& match, SemaphoreStep& step);
  void lapse(double time_s, bool seen, SemaphoreStep& step);
  void end_hold(SemaphoreStep& step);

  SemaphoreTemplates templates_;
  ParticleStations stations_;
  MovementDetector movements_;
  std::deque<Sample> recent_;
  std::optional<double> last_;        // time of the last call
  std::optional<double> last_state_;  // time of the last state
  std::optional<SignHold> held_;
  std::optional<double> left_;  // when the arms left the sign that is held
  std::optional<SignHold> candidate_;
};

}  // namespace choreo::recognition
