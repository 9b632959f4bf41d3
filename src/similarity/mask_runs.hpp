// SPDX-License-Identifier: Apache-2.0
// Silhouettes compared by their runs.
#pragma once

#include <cstdint>
#include <vector>

#include "similarity/and_count.hpp"
#include "similarity/bit_buffer.hpp"
#include "similarity/comparer.hpp"
#include "similarity/mask_table.hpp"

namespace choreo::similarity {

/// Every pair by the runs of one mask and the sums of the other: exact, and far fewer steps than there are pixels.
///
/// A line of a silhouette is a few runs [s, e). With P_B(x) = how many pixels B has left of x on that line, the pixels
/// that A and B have in common there are the sum over A's runs of P_B(e) - P_B(s). Columns of the matrix come by
/// kRunLanes: their sums lie side by side, so one addition serves them all. The sums of a few lines at a time are made,
/// small enough for the second cache, and all rows visit them before they give way to the next lines'.
///
/// The mirror image's runs are the mask's, backwards; its shift sigma is one place in P. Within blocks of 2 kRunLanes
/// columns the columns are sorted by the fraction f that decides sigma, so mostly all lanes need the same.
class MaskRuns final : public Comparer {
 public:
  MaskRuns(MaskStates states, std::shared_ptr<const MaskTable> table, AndCountKernel kernel);

  /// Whether canvases so wide can be compared in this way: a line's count must fit 16 bits.
  [[nodiscard]] static bool possible(const MaskTable& table);

  [[nodiscard]] std::size_t size() const override { return table_->size(); }
  void compare(Range rows, Range cols, MatrixView<float> z, MatrixView<float> zstar) const override;
  [[nodiscard]] std::size_t bytes() const;

 private:
  /// The runs of every state's mask or mirror image, chunk by chunk.
  struct Runs {
    std::vector<std::uint32_t> places;  // Begin and end of every run, as indices into the chunk's sums.
    std::vector<std::size_t> begins;    // Of state i's chunk c: [i * chunks + c]; one more at the end.
  };
  class Group;

  void add_runs(const body::MaskState* state);

  std::shared_ptr<const MaskTable> table_;
  AndCountKernel kernel_;
  std::size_t line_bytes_ = 0;   // Of a line of one mask: a byte is eight pixels.
  std::size_t chunk_lines_ = 1;  // Whose sums are held at a time.
  std::size_t chunks_ = 0;
  Runs straight_;
  Runs mirrored_;
  std::vector<std::uint32_t> lanes_;  // By group and lane: the state, or the number of states for none.
  BitBuffer columns_;                 // By group, line, byte of the line and lane.
};

}  // namespace choreo::similarity
