// SPDX-License-Identifier: Apache-2.0
// What is known of a face in a picture.
#pragma once

#include <opencv2/core/types.hpp>

namespace choreo::vision {

/// A face as a detector finds it in one picture.
struct Face {
  cv::Rect2d box;         ///< In pixels of the picture that was searched.
  double confidence = 0;  ///< (0, 1].
};

/// A face that is followed through the pictures. All lengths in pixels of the picture at the working resolution.
struct TrackedFace {
  cv::Point2d centre;
  double width = 0;       ///< Cheek to cheek, a tenth of the body's height (body::vitruvian::kFaceWidth); > 0.
  double confidence = 0;  ///< (0, 1]; falls while nothing new is seen.
  double age_s = 0;       ///< Since it was first seen.
  double unseen_s = 0;    ///< Since it was last seen, by a detector or the network; the face coasts meanwhile.
};

}  // namespace choreo::vision
