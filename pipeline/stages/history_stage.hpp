// SPDX-License-Identifier: Apache-2.0
// state -> row of Z and Z* against the history.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <span>
#include <utility>

#include "pipeline/latency.hpp"
#include "pipeline/stage.hpp"
#include "similarity/mask_history.hpp"
#include "similarity/particle_history.hpp"

namespace choreo::pipeline {

/// What a live row costs with the ring full; readable while the stage runs.
/// @thread thread-safe
class RowCost {
 public:
  void add(Nanoseconds duration, bool full) { (full ? full_ : filling_).add(duration); }
  [[nodiscard]] Latency full() const { return full_.summary(); }
  [[nodiscard]] Latency filling() const { return filling_.summary(); }

 private:
  LatencyHistogram full_;
  LatencyHistogram filling_;
};

/// Compares every state with those of the last minutes, once for Z and Z* together.
///
/// Rows older than the history's length go by time, before a frame is compared; where more frames come than the ring
/// holds, the oldest go as well.
class HistoryStage final : public Stage {
 public:
  /// @param length  > 0: a frame is compared with those that came less than this before it.
  /// @param history  may begin with states of its own, whose times nobody knows: they go by number alone.
  /// @param cost  may be null.
  HistoryStage(similarity::MaskHistory& history, Nanoseconds length, const Clock& clock, RowCost* cost)
      : HistoryStage(history, length, clock, cost, [&history](const Observation& o, Row z, Row zstar) {
          history.append(o.state.get(), z, zstar);
          return o.state != nullptr;
        }) {}

  /// Likewise of the particle states: a frame without one is a gap.
  HistoryStage(similarity::ParticleHistory& history, Nanoseconds length, const Clock& clock, RowCost* cost)
      : HistoryStage(history, length, clock, cost, [&history](const Observation& o, Row z, Row zstar) {
          history.append(o.particles ? &*o.particles : nullptr, z, zstar);
          return o.particles.has_value();
        }) {}

  [[nodiscard]] std::string name() const override { return "compare"; }
  void process(Observation& observation) override;

 private:
  using Row = std::span<float>;
  // Appends an observation's state to the history; whether it had one.
  using Append = std::function<bool(const Observation&, Row z, Row zstar)>;

  HistoryStage(similarity::History& history, Nanoseconds length, const Clock& clock, RowCost* cost, Append append)
      : history_(history), append_(std::move(append)), length_(length), clock_(clock), cost_(cost) {}

  similarity::History& history_;
  Append append_;
  Nanoseconds length_;
  const Clock& clock_;
  RowCost* cost_;
  std::deque<Nanoseconds> times_;  // Of the history's rows.
  bool full_ = false;              // A row went for a newer one.
};

}  // namespace choreo::pipeline
