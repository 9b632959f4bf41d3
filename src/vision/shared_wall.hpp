// SPDX-License-Identifier: Apache-2.0
// The wall behind somebody of whom there are several pictures, and what in each of them is not the wall.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace choreo::vision {

/// Pictures that show one scene, on one canvas that holds all of them.
struct SharedScene {
  cv::Size canvas;
  std::vector<std::size_t> members;  ///< Which of the pictures, increasing; the first scene has the most.
  /// Of each member: takes a place on the canvas to the picture's.
  std::vector<cv::Matx23d> picture_from_canvas;
};

/// Groups pictures by the scenes that they show. A picture that shares its scene with no other is in no group.
///
/// All are aligned with one that is typical (`align_scene`); what is left over is grouped again. Of more than 32
/// pictures those that cannot be one scene by their sketches (`SceneSketch`) are not aligned. Pictures are tried four
/// at a time as what others lie on, and after 64 in a row that cost alignments and on which none does the rest are
/// taken for strangers: a small group among many of them may be missed.
/// @param pictures  CV_8UC3, of any sizes; only pictures of one size share a scene.
/// @param progress  told what is done, 0 to 1, increasing; how much there is to do is guessed. May be empty.
/// @return nothing where `stop` was requested, which is looked at before every alignment.
/// @cost  one alignment a picture of a scene, a few more to find the typical one, and of strangers one for every pair
///   that looks alike; uses all cores, and the result does not depend on how many.
[[nodiscard]] std::optional<std::vector<SharedScene>> shared_scenes(std::span<const cv::Mat> pictures,
                                                                    const std::function<void(double)>& progress = {},
                                                                    std::stop_token stop = {});

/// One picture beside the wall, on the canvas.
struct AgainstWall {
  cv::Mat bgr;         ///< CV_8UC3, in the wall's light; black where not covered.
  cv::Mat covered;     ///< CV_8UC1, 255 where the picture has pixels.
  cv::Mat difference;  ///< CV_8UC1, D against the nearest of what the wall shows within a pixel.
  cv::Mat differs;     ///< CV_8UC1, 255 where that is more than noise.
  cv::Mat certainty;   ///< CV_8UC1, how far beyond noise: 0 to 255, what no shadow does.
};

/// The commonest view of a scene, and what is to be expected of pictures of it.
///
/// The exposures are brought together (`ToneCurve`), then each pixel is the median of the pictures that cover it. What
/// a body hides in more than half of the pictures is body: an arm before the trunk differs from it all the same.
/// Edges that lie half a pixel apart from picture to picture are no difference: a pixel is compared with the range of
/// the wall's 3 x 3 neighbourhood, and where the pictures themselves do not agree (leaves, a clock), more is asked.
class SharedWall {
 public:
  static constexpr std::size_t kMostPictures = 61;  ///< From which the wall is made; of more, evenly spread ones.

  /// @param pictures  all that `scene.members` may name.
  /// @cost O(pictures x pixels); uses all cores, and the result does not depend on how many.
  SharedWall(std::span<const cv::Mat> pictures, const SharedScene& scene);

  /// Standard deviation of D, grey levels.
  [[nodiscard]] double noise() const { return noise_; }

  /// @param picture  CV_8UC3, one of the scene's.
  /// @param picture_from_canvas  as of `SharedScene`.
  /// @param least_threshold  grey levels of D that always count as noise.
  [[nodiscard]] AgainstWall compare(const cv::Mat& picture, const cv::Matx23d& picture_from_canvas,
                                    double least_threshold = 7) const;

 private:
  [[nodiscard]] cv::Mat difference_from(const cv::Mat& picture) const;

  cv::Mat plate_, smooth_;
  cv::Mat darkest_, brightest_;  // CV_8UC3, of the 3 x 3 neighbourhood.
  cv::Mat unrest_;               // CV_8UC1, median of D over the pictures.
  double noise_ = 0;
};

}  // namespace choreo::vision
