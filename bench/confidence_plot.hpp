// SPDX-License-Identifier: Apache-2.0
// The share of right answers over the confidence that was told.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

namespace choreo::bench {

struct Answer {
  double confidence = 0;  ///< Above 0, to 1.
  bool right = false;
};

struct NamedAnswers {
  std::string name;
  std::vector<Answer> answers;
};

/// From, to; the first is excluded.
[[nodiscard]] std::span<const std::pair<double, double>> confidence_bins();

/// A panel each: one dot a bin, at the mean of what was told, as large as there are answers, with the interval in which
/// the share lies by 95 of 100 (Wilson); on the diagonal what is told is true.
/// @param path  of a PNG file. @throws Error (failure) where it cannot be written.
void plot_confidence(const std::vector<NamedAnswers>& all, const std::string& path);

}  // namespace choreo::bench
