// SPDX-License-Identifier: Apache-2.0
// A few things out of many, evenly spread.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <utility>
#include <vector>

#include <opencv2/core/types.hpp>

namespace choreo::pipeline {

/// Keeps items evenly spread over a stream of unknown length: every `step`-th, and with twice the step whenever there
/// are too many.
/// @thread thread-bound
template <typename T>
class EvenSampler {
 public:
  explicit EvenSampler(std::size_t most) : most_(most) { assert(most > 0); }

  /// Whether the next item that is offered is kept.
  [[nodiscard]] bool wants() const { return seen_ % (kept_.size() == most_ ? 2 * step_ : step_) == 0; }

  /// @param make  makes the next item; called only where it is kept.
  template <typename Make>
  void offer(Make&& make) {
    const auto number = seen_++;
    if (number % step_ != 0) return;
    if (kept_.size() == most_) {
      for (std::size_t i = 2; i < kept_.size(); i += 2) kept_[i / 2] = std::move(kept_[i]);
      kept_.resize((kept_.size() + 1) / 2);
      step_ *= 2;
      if (number % step_ != 0) return;
    }
    kept_.push_back(std::forward<Make>(make)());
  }

  void add(T item) {
    offer([&] { return std::move(item); });
  }

  /// Items 0, step, 2 step, ... of those offered, where step is a power of two.
  [[nodiscard]] const std::vector<T>& kept() const { return kept_; }

 private:
  std::size_t most_;
  std::size_t seen_ = 0;
  std::size_t step_ = 1;
  std::vector<T> kept_;
};

/// How many CV_8UC3 pictures of that size to keep: 8 to 120, together at most 256 MiB where that is more than 8.
[[nodiscard]] inline std::size_t most_pictures(cv::Size size) {
  constexpr std::size_t kBytes = std::size_t{256} << 20;
  const auto bytes = std::max<std::size_t>(1, std::size_t(size.width) * std::size_t(size.height) * 3);
  return std::clamp<std::size_t>(kBytes / bytes, 8, 120);
}

}  // namespace choreo::pipeline
