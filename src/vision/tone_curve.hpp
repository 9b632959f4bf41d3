// SPDX-License-Identifier: Apache-2.0
// The light of one picture in another: exposure, white balance and tone as one curve a channel.
#pragma once

#include <array>
#include <cstdint>

#include <opencv2/core/mat.hpp>

namespace choreo::vision {

/// A monotone curve per channel that takes the grey levels of one picture to those of another of the same scene.
///
/// Cameras change exposure and white balance as somebody walks in, and phones bend tones as well; such a change is the
/// same for all pixels of one level, which a body is not. For each sixteenth of the levels the curve takes the
/// commonest change; straight lines join them. Where most pixels keep their level, changes of a level elsewhere are
/// noise: such a curve is the identity.
class ToneCurve {
 public:
  /// The identity.
  ToneCurve();

  /// @param from, to  CV_8UC3 of one size and scene.
  /// @param except  CV_8UC1 of that size: pixels to leave out where not 0, such as the last body; may be empty.
  /// @param spread  how much the change at one level may differ from the commonest over all levels, grey levels; keeps
  ///   clothes that are most of what a level has from being taken for the wall.
  /// @cost O(pixels / 8): of every second row and column, of a large picture of every fourth row, is looked at.
  ToneCurve(const cv::Mat& from, const cv::Mat& to, const cv::Mat& except = {}, int spread = 24);

  /// `picture` in the other's light. CV_8UC3.
  [[nodiscard]] cv::Mat apply(const cv::Mat& picture) const;

 private:
  std::array<std::array<std::uint8_t, 256>, 3> levels_;  // By channel: the level after by the level before.
};

}  // namespace choreo::vision
