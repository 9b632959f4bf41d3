// SPDX-License-Identifier: Apache-2.0
#include "timing.hpp"

#include <algorithm>
#include <cstddef>
#include <ctime>

namespace choreo::bench {
namespace {

double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

}  // namespace

std::vector<double> interleaved_medians(int repetitions, const std::vector<std::function<void()>>& work) {
  for (const auto& piece : work) piece();
  std::vector<std::vector<double>> seconds(work.size());
  for (int turn = 0; turn < repetitions; ++turn) {
    for (std::size_t k = 0; k < work.size(); ++k) {
      const auto begin = processor_seconds();
      work[k]();
      seconds[k].push_back(processor_seconds() - begin);
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
