// SPDX-License-Identifier: Apache-2.0
// One step of the way of an observation.
#pragma once

#include <string>

#include "pipeline/observation.hpp"

namespace choreo::pipeline {

/// Adds something to every observation, in order of time. A thin adapter: the work is done by the mathematics.
/// @thread thread-bound; one thread calls it from the first observation to the last.
class Stage {
 public:
  virtual ~Stage() = default;

  /// A word a user knows; also the name of the thread (at most 15 characters).
  [[nodiscard]] virtual std::string name() const = 0;

  /// @throws Error where the run cannot go on.
  virtual void process(Observation& observation) = 0;
};

}  // namespace choreo::pipeline
