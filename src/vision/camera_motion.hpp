// SPDX-License-Identifier: Apache-2.0
// How a camera that shakes, or is held in the hand, moved since a reference picture.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace choreo::vision {

enum class CameraKind : std::uint8_t {
  kStill,
  kShakes,   ///< About one place, so that every picture can be brought back to it.
  kMayMove,  ///< The room is not found again in many pictures: it is to be watched from picture to picture.
};

/// From a place in the reference to the same place of the room in the picture. Pixel centres at whole numbers.
using CameraShift = cv::Matx23d;
inline const CameraShift kNoShift = {1, 0, 0, 0, 1, 0};

/// Follows the corners of a room from a reference picture to others, by Lucas and Kanade's pyramids, and takes the
/// shift, turn and scale that most of them agree on (RANSAC), at least a quarter: by chance at most an eighth does.
/// What moves in front has no word.
/// @thread reentrant
class CameraMotion {
 public:
  /// @param reference  CV_8UC3 or CV_8UC1.
  /// @param covered  CV_8UC1, 255 where there are no corners to be taken; may be empty.
  explicit CameraMotion(const cv::Mat& reference, const cv::Mat& covered = {});

  /// Whether the reference has enough corners.
  [[nodiscard]] bool can_tell() const;

  /// @param picture  of the reference's size and type.  @param guess  where to begin to look.
  /// @param stands_px  what moves by less stands still.
  /// @return nothing where too little of the room is found again; `kNoShift` where most of it stands still, so that a
  ///   camera on a tripod does so to the last bit.
  [[nodiscard]] std::optional<CameraShift> of(const cv::Mat& picture, const CameraShift& guess = kNoShift,
                                              double stands_px = 0.5) const;

 private:
  std::vector<cv::Mat> pyramid_;
  std::vector<cv::Point2f> corners_;
};

/// Whether bringing pictures back makes most of what differs from the reference vanish in most parts of it: somebody
/// who leans takes corners along, and the room beside them stands still. The light is made up for.
/// @param shifts  as many; of those that are nothing, or `kNoShift`, nothing is asked.
[[nodiscard]] bool explains(std::span<const std::optional<CameraShift>> shifts, std::span<const cv::Mat> pictures,
                            const cv::Mat& reference);

/// What the shifts of some pictures say. Nothing stands for a picture in which too little is found again.
/// @param explained  whether they explain what differs.
[[nodiscard]] CameraKind kind_of(std::span<const std::optional<CameraShift>> shifts, bool explained);

/// The picture as the reference would show it; what lies outside of it is taken from `beyond`.
[[nodiscard]] cv::Mat brought_back(const cv::Mat& picture, const CameraShift& shift, const cv::Mat& beyond);

/// A mask of the reference as the picture has it, 0 or 255; what the reference does not show is taken from `beyond`.
[[nodiscard]] cv::Mat taken_along(const cv::Mat& mask, const CameraShift& shift, const cv::Mat& beyond);

}  // namespace choreo::vision
