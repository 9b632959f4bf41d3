// SPDX-License-Identifier: Apache-2.0
#include "similarity/mask_comparer.hpp"

#include <cassert>
#include <utility>

#include "similarity/mask_bits.hpp"
#include "similarity/mask_runs.hpp"

namespace choreo::similarity {
namespace {

// An end of a run costs about as much as one or two bytes of a bit string, by the instruction set.
bool runs_are_faster(const MaskTable& table) {
  const auto ends = 2.0 * double(table.runs);
  const auto bytes = double(table.canvas.area()) / 8 * double(table.size());
  return 2 * ends < bytes;
}

}  // namespace

MaskComparer::MaskComparer(MaskStates states, AndCountKernel kernel, Method method)
    : table_(std::make_shared<const MaskTable>(states)) {
  const bool runs =
      method != Method::kBits && MaskRuns::possible(*table_) && (method == Method::kRuns || runs_are_faster(*table_));
  if (runs) {
    auto comparer = std::make_unique<MaskRuns>(states, table_, std::move(kernel));
    method_ = Method::kRuns;
    bytes_ = comparer->bytes();
    comparer_ = std::move(comparer);
  } else {
    auto comparer = std::make_unique<MaskBits>(states, table_, std::move(kernel));
    bytes_ = comparer->bytes();
    comparer_ = std::move(comparer);
  }
}

void MaskComparer::compare(Range rows, Range cols, MatrixView<float> z, MatrixView<float> zstar) const {
  assert(z.rows() == rows.size() && z.cols() == cols.size());
  assert(zstar.rows() == rows.size() && zstar.cols() == cols.size());
  comparer_->compare(rows, cols, z, zstar);
}

}  // namespace choreo::similarity
