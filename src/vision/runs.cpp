// SPDX-License-Identifier: Apache-2.0
#include "vision/runs.hpp"

#include <algorithm>
#include <cassert>

namespace choreo::vision {
namespace {

// Which provisional parts are one.
class Unions {
 public:
  std::size_t make() {
    parent_.push_back(parent_.size());
    return parent_.back();
  }
  std::size_t root(std::size_t k) {
    while (parent_[k] != k) {
      parent_[k] = parent_[parent_[k]];
      k = parent_[k];
    }
    return k;
  }
  // The older one stays, so that a root is the part's first in reading order.
  std::size_t join(std::size_t a, std::size_t b) {
    a = root(a);
    b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
    return std::min(a, b);
  }
  [[nodiscard]] std::size_t size() const { return parent_.size(); }

 private:
  std::vector<std::size_t> parent_;
};

}  // namespace

Parts parts_of(const cv::Mat& mask, Neighbours neighbours) {
  assert(mask.empty() || mask.type() == CV_8UC1);
  const int corner = neighbours == Neighbours::kEight ? 1 : 0;
  Parts parts;
  auto& runs = parts.runs;
  auto& part_of = parts.part_of;  // Provisional at first.
  Unions unions;
  std::size_t above = 0;  // First run of the line above.
  std::size_t above_end = 0;
  for (int y = 0; y < mask.rows; ++y) {
    const auto first = runs.size();
    auto next = above;
    for_each_run(mask.ptr<std::uint8_t>(y), mask.cols, [&](int from, int to) {
      bool joined = false;
      std::size_t own = 0;
      // Runs above that touch this one.
      while (next < above_end && runs[next].to + corner <= from) ++next;
      for (auto k = next; k < above_end && runs[k].from < to + corner; ++k) {
        own = joined ? unions.join(own, part_of[k]) : unions.root(part_of[k]);
        joined = true;
      }
      runs.push_back({y, from, to});
      part_of.push_back(joined ? own : unions.make());
    });
    above = first;
    above_end = runs.size();
  }
  // A root is the least of its part.
  std::vector<std::size_t> number(unions.size());
  for (std::size_t k = 0; k < number.size(); ++k) {
    const auto root = unions.root(k);
    number[k] = root == k ? parts.count++ : number[root];
  }
  for (auto& part : part_of) part = number[part];
  return parts;
}

}  // namespace choreo::vision
