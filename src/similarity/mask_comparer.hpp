// SPDX-License-Identifier: Apache-2.0
// Z and Z* of silhouettes, fast.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "body/mask_state.hpp"
#include "similarity/and_count.hpp"
#include "similarity/bit_buffer.hpp"
#include "similarity/comparer.hpp"

namespace choreo::similarity {

/// Silhouettes as bit strings on one canvas, cropped to what the bodies occupy around their centroids.
///
/// Every value equals the specification (`body::similarity`, `body::mirror_similarity`) to the last bit of a float:
/// both count the same pixels and divide alike. The canvas keeps a column on either side in which no mask has
/// a bit, so that the mirror's shift by one pixel is a shift of the whole string by one bit.
class MaskComparer final : public Comparer {
 public:
  /// @param states  one a frame, empty where a frame has no body; may be destroyed afterwards.
  MaskComparer(std::span<const std::unique_ptr<const body::MaskState>> states, AndCountKernel kernel);

  [[nodiscard]] std::size_t size() const override { return areas_.size(); }
  void compare(Range rows, Range cols, MatrixView<float> z, MatrixView<float> zstar) const override;

  [[nodiscard]] cv::Size canvas() const { return canvas_.size(); }          ///< Pixels, margins included.
  [[nodiscard]] std::size_t bytes_per_state() const { return 2 * bytes_; }  ///< The mask and its mirror image.

 private:
  class Scratch;

  [[nodiscard]] const std::uint8_t* mask(std::size_t i) const { return bits_.get() + 2 * i * bytes_; }
  [[nodiscard]] const std::uint8_t* mirror(std::size_t i) const { return mask(i) + bytes_; }

  AndCountKernel kernel_;
  cv::Rect canvas_;                  // In coordinates relative to the centroid.
  std::size_t bytes_ = 0;            // Of one bit string, a multiple of kBitAlignment.
  std::vector<std::int64_t> areas_;  // 0: a gap.
  std::vector<std::int64_t> remainders_;
  BitBuffer bits_;  // A mask and its mirror image a state.
};

}  // namespace choreo::similarity
