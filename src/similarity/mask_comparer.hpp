// SPDX-License-Identifier: Apache-2.0
// Z and Z* of silhouettes, fast.
#pragma once

#include <cstddef>
#include <memory>

#include "similarity/and_count.hpp"
#include "similarity/comparer.hpp"
#include "similarity/mask_table.hpp"

namespace choreo::similarity {

/// Silhouettes around their centroids on one canvas, cropped to what the bodies occupy.
///
/// Every value equals the specification (`body::similarity`, `body::mirror_similarity`) to the last bit of a float:
/// all count the same pixels and divide alike. Which of two ways counts them only decides how long it takes.
class MaskComparer final : public Comparer {
 public:
  enum class Method {
    kFaster,  ///< Runs where the masks are bodies; bits where they are more like noise.
    kBits,    ///< AND and population count of bit strings (MaskBits).
    kRuns,    ///< Sums at the ends of runs (MaskRuns); bits after all where a line has more than 65,528 pixels.
  };

  /// @param states  one a frame, empty where a frame has no body; may be destroyed afterwards.
  MaskComparer(MaskStates states, AndCountKernel kernel, Method method = Method::kFaster);

  [[nodiscard]] std::size_t size() const override { return table_->size(); }
  void compare(Range rows, Range cols, MatrixView<float> z, MatrixView<float> zstar) const override;

  [[nodiscard]] cv::Size canvas() const { return table_->canvas.size(); }  ///< Pixels, margins included.
  [[nodiscard]] std::size_t bytes() const { return bytes_; }               ///< Held for comparing.
  [[nodiscard]] Method method() const { return method_; }                  ///< kBits or kRuns.

 private:
  std::shared_ptr<const MaskTable> table_;
  Method method_ = Method::kBits;
  std::size_t bytes_ = 0;
  std::unique_ptr<const Comparer> comparer_;
};

}  // namespace choreo::similarity
