// SPDX-License-Identifier: Apache-2.0
// The wall behind a body that never leaves: what of it was seen between the limbs, and where it was never seen at all.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace choreo::vision {

/// A wall that was pieced together.
struct InferredWall {
  cv::Mat plate;   ///< CV_8UC3; where the wall was never seen, a smooth guess from what is around.
  cv::Mat unseen;  ///< CV_8UC1, 255 where the body stood in every picture.
  cv::Mat reach;   ///< CV_8UC1, 255 where the body was in any picture, and near it.
  cv::Mat ghost;   ///< CV_8UC3, the body's commonest colour where `unseen` is set, else 0.
};

/// Tells body and wall apart in pictures of a body that may stand before the same wall all the time.
///
/// Every pixel shows a few colours over time (`colour_modes`), and each of them is either body or wall; pictures that
/// show the same colour at a pixel share one answer. The answers are those of the least energy: colours that are
/// likelier on one of the two (`ColourOdds`) ask for it, neighbours that are seen together and look alike ask for the
/// same; the minimum is found by a cut (`MinCut`). The first odds are taken from what is certain: what never moves
/// beside the body's reach is wall, and what passes before it is body. Answers and odds are then improved in turn.
/// @param pictures  in one light; at least one, CV_8UC3, of one size; evenly spread in time.
/// @param noise  standard deviation of the sensor's noise in D, grey levels.
/// @source Boykov and Jolly, ICCV 2001, for the energy; Rother, Kolmogorov, Blake, GrabCut, 2004, for taking turns.
///   Ours are nodes of pixel and colour instead of pixels of one picture.
[[nodiscard]] InferredWall infer_wall(std::span<const cv::Mat> pictures, double noise);

/// `infer_wall` in steps that each take about as long, for whoever has other things to do in between: the whole takes a
/// quarter of a second for 40 pictures of 160 x 120.
/// @thread thread-bound
class WallInference {
 public:
  /// @param pictures  as of `infer_wall`; kept by reference until the first step is done, and must not change.
  WallInference(std::vector<cv::Mat> pictures, double noise);
  ~WallInference();
  WallInference(WallInference&&) noexcept;
  WallInference& operator=(WallInference&&) noexcept;

  /// Takes the next step. @return whether it was the last.
  bool advance();
  /// The answer, once `advance` has returned true.
  [[nodiscard]] const InferredWall& wall() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace choreo::vision
