// SPDX-License-Identifier: Apache-2.0
// How many cores the loops of this process take.
#pragma once

#include <memory>

namespace choreo::pipeline {

/// While this lives, oneTBB's loops take at most so many cores, and OpenCV's are done by the thread that calls them.
///
/// OpenCV's own parallel loops do not suit several threads: what keeps one within another from dividing is one flag of
/// the whole process. While any thread is in such a loop those of all others are serial, and what begins under
/// another's flag takes all cores as soon as that is down. So all that is parallel here is one thread a stage, and
/// oneTBB.
/// @thread made and destroyed while no loop runs
class CoreLimit {
 public:
  /// @param threads  >= 1.
  explicit CoreLimit(int threads);
  ~CoreLimit();
  CoreLimit(const CoreLimit&) = delete;
  CoreLimit& operator=(const CoreLimit&) = delete;

 private:
  struct Limits;
  std::unique_ptr<const Limits> limits_;
};

}  // namespace choreo::pipeline
