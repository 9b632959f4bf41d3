// SPDX-License-Identifier: Apache-2.0
// What finds faces in a picture.
#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include "vision/face.hpp"

namespace choreo::vision {

/// How a picture is looked at. What costs more is asked for only where the cheap look found nothing.
enum class FaceLook {
  kFront,       ///< A face that looks into the camera.
  kBrightened,  ///< The same after lifting the shadows: dark skin, a window behind.
  kProfile,     ///< A face seen from either side.
  kAny,         ///< The first of these, in this order, that finds one.
};

/// Finds faces. The same picture gives the same faces, to the last bit, whatever was asked before.
/// @thread thread-bound
class FaceDetector {
 public:
  virtual ~FaceDetector() = default;
  FaceDetector() = default;
  FaceDetector(const FaceDetector&) = delete;
  FaceDetector& operator=(const FaceDetector&) = delete;

  /// @param grey  CV_8UC1, of any size, also empty.
  /// @param where  what is searched; what lies outside the picture is ignored.
  /// @param least_px, most_px  width of a face from cheek to cheek.
  /// @return  Best first. Every box is square, as wide as the face from cheek to cheek (a tenth of the body's height)
  ///   and centred between chin and hairline, whatever the detector's own boxes are like; it may reach over the border.
  /// @throws Error (failure) where the detector itself fails.
  [[nodiscard]] virtual std::vector<Face> detect(const cv::Mat& grey, const cv::Rect& where, double least_px,
                                                 double most_px, FaceLook look) = 0;
};

/// From a detector's own box to the face's.
struct FaceShape {
  double width = 1;     ///< Of the face over that of the detector's box.
  double centre_x = 0;  ///< Of the face from the centre of the detector's box, in widths of that box.
  double centre_y = 0;  ///< Likewise, down.

  [[nodiscard]] cv::Rect2d face(const cv::Rect2d& box) const {
    const double side = width * box.width;
    return {box.x + (0.5 + centre_x) * box.width - side / 2, box.y + box.height / 2 + centre_y * box.width - side / 2,
            side, side};
  }
};

/// All plausible faces of one picture, searched thoroughly and without regard to speed: every look at the picture as
/// it is, those from the front also twice as large and with its contrast evened out.
/// @param grey  CV_8UC1, of any size, also empty.
/// @param least_px  as of `FaceDetector::detect`.
/// @return  Best first, none twice. The confidence grows with the number of looks that agree.
/// @throws Error (failure) where the detector itself fails.
[[nodiscard]] std::vector<Face> all_faces(FaceDetector& detector, const cv::Mat& grey, double least_px);

/// Share of two faces' boxes that both cover, of what either covers, [0, 1].
[[nodiscard]] double overlap(const cv::Rect2d& a, const cv::Rect2d& b);

}  // namespace choreo::vision
