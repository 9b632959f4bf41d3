// SPDX-License-Identifier: Apache-2.0
// A person's mask: the network says where the person is, the difference from the background where the outline runs.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "vision/background_estimate.hpp"
#include "vision/body_masker.hpp"
#include "vision/person_evidence.hpp"

namespace choreo::vision {

/// The background behind people: per pixel and channel the median over the pictures in which nobody is likely there.
///
/// One or two pictures in a row that show nobody, while those before or after do, are those in which the network lost
/// somebody, and count as covered. All are brought to the light of the one in the middle first. Where somebody is in
/// all of them `never_seen` is set and the plate is a guess, the median of everything. `ghost` stays empty, and nothing
/// is inferred.
/// @param pictures  at least one, CV_8UC3, of one size.
/// @param people  as many, in the same order.
[[nodiscard]] BackgroundEstimate background_behind_people(std::span<const cv::Mat> pictures,
                                                          std::span<const PersonEvidence> people);

/// Makes a person's masks.
///
/// Body is what differs from the background near where the person is likely, and, where the difference has no word
/// (clothes like the room, a background that was never seen), what the network is sure of. Outlines are therefore the
/// picture's where the background is known, and the network's where it is not. What no look calls a person, a chair or
/// somebody else, is no body, nor what a look calls one where the room is as it was seen; what hands hold is. Who was
/// seen a moment ago and is lost to the network, upside down say, is followed by the difference for some seconds, and
/// what comes in at the border is body for a second, until the network has seen enough of it; and of what is surely not
/// the person the background is learned: what was never seen becomes known once it is seen, and slow light is followed.
/// The same pictures, times and evidence give the same masks, to the last bit.
/// @thread thread-bound
class PersonMasker {
 public:
  /// @param estimate  its plate, noise and never_seen are used.
  PersonMasker(const BackgroundEstimate& estimate, MaskOptions options);

  /// @param picture  CV_8UC3, of the plate's size (asserted).  @param time_s  seconds, increasing.
  [[nodiscard]] MaskResult process(const cv::Mat& picture, const PersonEvidence& looked, double time_s);

  /// The mask by the network alone, of a picture that tells nothing of the background; nothing is learned.
  [[nodiscard]] MaskResult silhouette(const PersonEvidence& person) const;

  /// Nothing is known of the room any more: the camera has moved.
  void forget(const cv::Mat& picture);

  [[nodiscard]] double threshold() const { return threshold_; }  ///< In use, grey levels of D.
  /// The background as it is now, CV_8UC3, in the plate's light; not to be written to.
  [[nodiscard]] const cv::Mat& background() const { return background_; }

 private:
  [[nodiscard]] cv::Mat foreground(const cv::Mat& picture, const cv::Mat& lit, const cv::Mat& difference) const;
  [[nodiscard]] cv::Mat expected(const PersonEvidence& person, double time_s) const;
  [[nodiscard]] bool is_the_room(const PersonEvidence& person, const cv::Mat& foreground) const;
  [[nodiscard]] cv::Mat with_the_networks_word(const cv::Mat& foreground, const PersonEvidence& person) const;
  [[nodiscard]] cv::Mat entering(const cv::Mat& foreground, double time_s);
  [[nodiscard]] MaskResult finished(cv::Mat mask) const;
  void learn(const cv::Mat& picture, const cv::Mat& lit, const cv::Mat& surely_not, double dt_s);

  MaskOptions options_;
  double threshold_;
  cv::Mat running_;     // CV_32FC3, the background in the light of the plate.
  cv::Mat background_;  // CV_8UC3, the same rounded.
  cv::Mat never_seen_;  // CV_8UC1, 255 where it is a guess.
  cv::Mat free_looks_;  // CV_8UC1, in how many pictures it was surely not the person's; in a row, while it is a guess.
  cv::Mat allowed_;     // CV_8UC1, where a body may be; empty: everywhere.
  cv::Mat last_mask_;   // CV_8UC1, the last body.
  cv::Mat lately_;      // CV_8UC1, where the person may have been a moment ago: 255 in the last picture, then less.
  std::optional<double> last_time_s_;
  std::optional<double> first_time_s_;
  std::optional<double> last_seen_s_;  // By the network.
  std::optional<double> entering_s_;   // Since when something is at the border that nobody is seen to be.
};

}  // namespace choreo::vision
