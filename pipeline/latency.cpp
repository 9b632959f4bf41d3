// SPDX-License-Identifier: Apache-2.0
#include "pipeline/latency.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace choreo::pipeline {

std::size_t LatencyHistogram::bucket_of(std::uint64_t nanoseconds) {
  const int octave = std::max(0, static_cast<int>(std::bit_width(nanoseconds)) - kBits - 1);
  return (static_cast<std::size_t>(octave) << kBits) + static_cast<std::size_t>(nanoseconds >> octave);
}

std::uint64_t LatencyHistogram::upper_edge(std::size_t bucket) {
  const auto octave = std::max<std::size_t>(bucket >> kBits, 1) - 1;
  const std::uint64_t mantissa = bucket - (octave << kBits);
  return ((mantissa + 1) << octave) - 1;
}

void LatencyHistogram::add(Nanoseconds duration) {
  const auto nanoseconds = static_cast<std::uint64_t>(std::max<Nanoseconds::rep>(0, duration.count()));
  const std::scoped_lock lock(mutex_);
  ++counts_[bucket_of(nanoseconds)];
  ++count_;
  max_ = std::max(max_, nanoseconds);
}

Latency LatencyHistogram::summary() const {
  const std::scoped_lock lock(mutex_);
  Latency latency;
  latency.count = count_;
  latency.max = Nanoseconds(max_);
  if (count_ == 0) return latency;
  // The duration that this share of all does not exceed.
  const auto percentile = [&](double share) {
    const auto wanted = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::ceil(share * double(count_))));
    std::uint64_t seen = 0;
    std::size_t bucket = 0;
    while ((seen += counts_[bucket]) < wanted) ++bucket;
    return Nanoseconds(std::min(upper_edge(bucket), max_));
  };
  latency.p50 = percentile(0.5);
  latency.p99 = percentile(0.99);
  latency.p999 = percentile(0.999);
  return latency;
}

}  // namespace choreo::pipeline
