// SPDX-License-Identifier: Apache-2.0
// Silhouettes compared as bit strings.
#pragma once

#include "similarity/and_count.hpp"
#include "similarity/bit_buffer.hpp"
#include "similarity/comparer.hpp"
#include "similarity/mask_table.hpp"

namespace choreo::similarity {

/// Every pair by AND and population count over the canvas, whatever the masks look like.
///
/// A mask is one string, line after line without padding, so that the mirror's shift by one pixel is a shift of the
/// whole string by one bit; the rows' three mirror images are made beforehand and each pair takes the one it needs.
class MaskBits final : public Comparer {
 public:
  MaskBits(MaskStates states, std::shared_ptr<const MaskTable> table, AndCountKernel kernel);

  [[nodiscard]] std::size_t size() const override { return table_->size(); }
  void compare(Range rows, Range cols, MatrixView<float> z, MatrixView<float> zstar) const override;
  [[nodiscard]] std::size_t bytes() const { return 2 * bytes_ * size(); }

 private:
  class Shifted;

  [[nodiscard]] const std::uint8_t* mask(std::size_t i) const { return bits_.get() + 2 * i * bytes_; }
  [[nodiscard]] const std::uint8_t* mirror(std::size_t i) const { return mask(i) + bytes_; }

  std::shared_ptr<const MaskTable> table_;
  AndCountKernel kernel_;
  std::size_t bytes_ = 0;  // Of one bit string, a multiple of kBitAlignment.
  BitBuffer bits_;         // A mask and its mirror image a state.
};

}  // namespace choreo::similarity
