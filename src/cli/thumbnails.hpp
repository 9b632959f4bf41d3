// SPDX-License-Identifier: Apache-2.0
// Small pictures of the body for the time axis of a plot.
#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include "body/mask_state.hpp"
#include "outputs/plot.hpp"
#include "pipeline/even_sampler.hpp"

namespace choreo::cli {

/// Chooses pictures while the frames pass, whose number nobody knows.
///
/// Keeps every k-th body, with twice the k whenever there are many, or those at given times; all cut out at one scale
/// around the centroid.
class ThumbnailKeeper {
 public:
  /// @param count  how many, evenly spread; ignored where `times_s` are given.
  ThumbnailKeeper(int count, std::vector<double> times_s);

  /// @param picture  CV_8UC3.  @param mask  CV_8UC1.  @param state  of that mask.
  void add(const cv::Mat& picture, const cv::Mat& mask, const body::MaskState& state, double time_s);

  /// The chosen ones, transparent outside the body, all of one size.
  /// @param from_s  none from before that time.
  [[nodiscard]] std::vector<outputs::Thumbnail> chosen(double from_s = 0) const;

 private:
  struct Kept {
    double time_s;
    cv::Rect box;     // Around the centroid.
    cv::Mat picture;  // CV_8UC4.
  };
  [[nodiscard]] static Kept cut_out(const cv::Mat& picture, const cv::Mat& mask, const body::MaskState& state,
                                    double time_s);

  std::size_t count_;
  std::vector<double> times_s_;  // Sorted; asked for.
  std::size_t next_time_ = 0;
  std::vector<Kept> at_times_;
  pipeline::EvenSampler<Kept> evenly_;
};

}  // namespace choreo::cli
