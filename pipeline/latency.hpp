// SPDX-License-Identifier: Apache-2.0
// How long frames take, with the rare slow ones that a mean would hide.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <mutex>

#include "core/time.hpp"

namespace choreo::pipeline {

/// The distribution of a duration.
struct Latency {
  std::uint64_t count = 0;
  Nanoseconds p50{0};
  Nanoseconds p99{0};
  Nanoseconds p999{0};
  Nanoseconds max{0};  ///< Exact; the percentiles are at most 1.6 % above the truth.
};

/// Counts durations in buckets whose width grows with them: fixed memory, however long the run.
///
/// Percentiles are the upper edges of their buckets, and never above the largest duration seen.
/// @thread thread-safe
class LatencyHistogram {
 public:
  /// @param duration  less than 0 counts as 0.
  void add(Nanoseconds duration);
  [[nodiscard]] Latency summary() const;

 private:
  // A bucket has a power of two and the six bits behind the leading one: 64 buckets an octave.
  static constexpr int kBits = 6;
  static constexpr std::size_t kBuckets = (65 - kBits) << kBits;
  [[nodiscard]] static std::size_t bucket_of(std::uint64_t nanoseconds);
  [[nodiscard]] static std::uint64_t upper_edge(std::size_t bucket);

  mutable std::mutex mutex_;
  std::array<std::uint64_t, kBuckets> counts_{};
  std::uint64_t count_ = 0;
  std::uint64_t max_ = 0;
};

}  // namespace choreo::pipeline
