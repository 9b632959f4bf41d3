// SPDX-License-Identifier: Apache-2.0
// Times of pieces of work that are to be compared with one another.
#pragma once

#include <functional>
#include <vector>

namespace choreo::bench {

/// The median time of each piece of work, in seconds of the calling thread on a processor: what other programs take
/// from a busy machine does not count, so pieces of work that run on one thread can be compared there too.
///
/// The pieces take turns, so that what else the machine does meets all of them alike; each is run once beforehand.
/// @param repetitions  turns, at least 1.
[[nodiscard]] std::vector<double> interleaved_medians(int repetitions, const std::vector<std::function<void()>>& work);

}  // namespace choreo::bench
