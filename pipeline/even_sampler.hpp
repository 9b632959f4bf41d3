// SPDX-License-Identifier: Apache-2.0
// A few pictures out of many, evenly spread.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace choreo::pipeline {

/// Keeps pictures evenly spread over a stream of unknown length: every `step`-th, and with twice the step whenever
/// there are too many.
/// @thread thread-bound
class EvenSampler {
 public:
  explicit EvenSampler(std::size_t most) : most_(most) { assert(most > 0); }

  /// How many CV_8UC3 pictures of that size to keep: 8 to 120, together at most 256 MiB where that is more than 8.
  [[nodiscard]] static std::size_t most_of(cv::Size size) {
    constexpr std::size_t kBytes = std::size_t{256} << 20;
    const auto bytes = std::max<std::size_t>(1, std::size_t(size.width) * std::size_t(size.height) * 3);
    return std::clamp<std::size_t>(kBytes / bytes, 8, 120);
  }

  /// @param picture  kept by reference: must not be changed afterwards.
  void add(const cv::Mat& picture) {
    const auto number = seen_++;
    if (number % step_ != 0) return;
    if (kept_.size() == most_) {
      std::size_t k = 0;
      for (std::size_t i = 0; i < kept_.size(); i += 2) kept_[k++] = kept_[i];
      kept_.resize(k);
      step_ *= 2;
      if (number % step_ != 0) return;
    }
    kept_.push_back(picture);
  }

  /// Pictures 0, step, 2 step, ... of those added, where step is a power of two.
  [[nodiscard]] const std::vector<cv::Mat>& pictures() const { return kept_; }

 private:
  std::size_t most_;
  std::size_t seen_ = 0;
  std::size_t step_ = 1;
  std::vector<cv::Mat> kept_;
};

}  // namespace choreo::pipeline
