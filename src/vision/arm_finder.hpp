// SPDX-License-Identifier: Apache-2.0
// From where the tone is to the two arms, by size, place and continuity.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "vision/arms.hpp"
#include "vision/blobs.hpp"
#include "vision/face.hpp"

namespace choreo::vision {

/// What an arm is. Lengths in face widths, areas in face widths squared; the defaults are the Vitruvian figure's.
struct ArmOptions {
  double min_probability = 0.5;  ///< A pixel is of the tone from this posterior on; above 0, at most 1.
  double anneal = 0.04;          ///< Gaps up to twice this close; 0 to 0.3.
  double reach = 3.75;           ///< Shoulder to fingertip; 1 to 10.
  double shoulder_aside = 1.25;  ///< From the face's middle; 0 to 5.
  double shoulder_below = 1.3;   ///< From the face's centre; 0 to 5.
  double typical_arm = 1.25;     ///< Area of a bare forearm, until two arms were seen; 0.1 to 10.
  double least_arm = 0.2;        ///< Smaller regions are no arms; 0.02 to 5.
  double largest_arm = 3.2;      ///< Larger ones neither; at least least_arm, at most 30.
  double least_piece = 0.04;     ///< Smaller regions are noise; 0 to least_arm.
  double piece_gap = 0.8;        ///< Pieces of one arm, split by a sleeve or a strap, lie no farther apart; 0 to 3.
  double memory_s = 0.5;         ///< The arms before count for this long; 0 to 10 s.

  /// @throws Error (usage) naming the field, its value and its range.
  void validate() const;
};

/// Finds the arms in the regions of a tone.
///
/// The tone's pixels within the body are annealed, the face's region (head and neck, sized by the face) is cut out,
/// and connected components are what may be arms. A component that holds both arms by its size or reach is cut along
/// the chest under the face where that leaves two whole arms (bare upper arms that join through a neckline). What lies
/// mostly beyond the reach of both shoulders (legs), on the chest alone, or is too large is no arm. Short pieces in
/// line are put together. Of what remains those two are the arms that are large, and near the arms of the frames
/// before. One that is as large as two, cannot be reached from one shoulder, or lies where two were, holds both:
/// kJoined.
/// @source Performance Physics, 5.3.7 to 5.4; the rules are ours.
/// @thread thread-bound; remembers the arms before.
class ArmFinder {
 public:
  /// @throws Error (usage), see `ArmOptions::validate`.
  explicit ArmFinder(const ArmOptions& options = {});

  /// @param posterior  CV_8UC1, the tone's probability as 0 to 255, no side longer than kLongestSide.
  /// @param body       CV_8UC1 of that size, body where not 0; empty: everywhere.
  /// @param face       in the same picture.
  /// @param time_s     seconds, not decreasing.
  [[nodiscard]] Arms find(const cv::Mat& posterior, const cv::Mat& body, const std::optional<TrackedFace>& face,
                          double time_s);

  /// The area of one arm, in face widths squared, as far as it is known: of `ArmOptions::typical_arm` at first, it
  /// follows the larger of two arms with a time constant of 0.65 s.
  [[nodiscard]] double typical_arm() const { return typical_; }

 private:
  struct Candidate;
  class Search;
  class Choice;

  ArmOptions options_;
  double typical_ = 0;
  // The arms of the last frame that had any, in face widths from the face; two where joined, at the same place.
  std::vector<cv::Point2d> before_;
  bool joined_before_ = false;
  double before_s_ = 0;
  std::optional<double> last_s_;
};

}  // namespace choreo::vision
