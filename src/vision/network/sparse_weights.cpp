// SPDX-License-Identifier: Apache-2.0
#include "vision/network/sparse_weights.hpp"

#include <cstddef>
#include <functional>
#include <numeric>

#include <fmt/format.h>

#include "core/error.hpp"

namespace choreo::vision {
namespace {

class Spreading {
 public:
  Spreading(const std::vector<SparseLevel>& levels, const std::vector<int>& shape, const std::vector<float>& values)
      : levels_(levels), shape_(shape), values_(values) {
    if (levels.size() != shape.size()) refuse_network("has sparse weights of an odd shape");
    dense_.assign(std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies<>()), 0.0F);
    walk(0, 0, 0);
    if (next_ != values.size()) refuse_network("has sparse weights that nothing points at");
  }

  [[nodiscard]] std::vector<float> take() { return std::move(dense_); }

 private:
  // What is below entry `at` of the level above, whose place among the dense ones is `place`.
  void walk(std::size_t depth, std::size_t at, std::size_t place) {
    if (depth == levels_.size()) {
      if (next_ >= values_.size()) refuse_network("has too few sparse weights");
      dense_[place] = values_[next_++];
      return;
    }
    const auto& level = levels_[depth];
    const auto size = std::size_t(shape_[depth]);
    if (!level.sparse) {
      for (std::size_t k = 0; k < size; ++k) walk(depth + 1, at * size + k, place * size + k);
      return;
    }
    if (at + 1 >= level.segments.size()) refuse_network("has sparse weights with a row too few");
    const int from = level.segments[at];
    const int to = level.segments[at + 1];
    if (from < 0 || from > to || std::size_t(to) > level.indices.size()) {
      refuse_network("has sparse weights of odd rows");
    }
    int last = -1;
    for (int k = from; k < to; ++k) {
      const int index = level.indices[std::size_t(k)];
      if (index <= last || index >= shape_[depth]) refuse_network("has sparse weights outside their rows");
      last = index;
      walk(depth + 1, std::size_t(k), place * size + std::size_t(index));
    }
  }

  const std::vector<SparseLevel>& levels_;
  const std::vector<int>& shape_;
  const std::vector<float>& values_;
  std::vector<float> dense_;
  std::size_t next_ = 0;
};

}  // namespace

std::vector<float> dense_weights(const std::vector<SparseLevel>& levels, const std::vector<int>& shape,
                                 const std::vector<float>& values) {
  return Spreading(levels, shape, values).take();
}

void refuse_network(std::string_view what) {
  throw usage_error(fmt::format("the network {}", what), {},
                    "the pose models of the npm package @mediapipe/pose are what is read");
}

}  // namespace choreo::vision
