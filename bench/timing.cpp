// SPDX-License-Identifier: Apache-2.0
#include "timing.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>

namespace choreo::bench {

std::vector<double> interleaved_medians(int repetitions, const std::vector<std::function<void()>>& work) {
  using Clock = std::chrono::steady_clock;
  for (const auto& piece : work) piece();
  std::vector<std::vector<double>> seconds(work.size());
  for (int turn = 0; turn < repetitions; ++turn) {
    for (std::size_t k = 0; k < work.size(); ++k) {
      const auto begin = Clock::now();
      work[k]();
      seconds[k].push_back(std::chrono::duration<double>(Clock::now() - begin).count());
    }
  }
  std::vector<double> medians;
  for (auto& of_one : seconds) {
    const auto middle = of_one.begin() + std::ptrdiff_t(of_one.size() / 2);
    std::nth_element(of_one.begin(), middle, of_one.end());
    medians.push_back(*middle);
  }
  return medians;
}

}  // namespace choreo::bench
