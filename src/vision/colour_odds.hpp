// SPDX-License-Identifier: Apache-2.0
// How much likelier a colour is on the body than on the wall, from pixels of which is known what they are.
#pragma once

#include <vector>

#include <opencv2/core/matx.hpp>

namespace choreo::vision {

/// Two smoothed histograms of colour and Bayes' rule.
///
/// log P(colour | body) / P(colour | wall), each mixed with a little of the uniform density, so that colours that were
/// never seen on either say nothing and one outlier does not say everything.
class ColourOdds {
 public:
  ColourOdds();
  void add_body(const cv::Vec3b& colour, float weight) { body_[bin(colour)] += weight; }
  void add_wall(const cv::Vec3b& colour, float weight) { wall_[bin(colour)] += weight; }

  /// To be called after the last add and before the first ask.
  void finish();

  /// Natural logarithm of the odds; above 0: rather body.
  [[nodiscard]] float log_odds(const cv::Vec3b& colour) const { return odds_[bin(colour)]; }

 private:
  static constexpr int kShift = 3;  // Bins of eight grey levels: finer than cloth is shaded, coarser than noise.
  static constexpr int kBins = 256 >> kShift;
  static std::size_t bin(const cv::Vec3b& c) {
    return (std::size_t(c[2] >> kShift) * kBins + std::size_t(c[1] >> kShift)) * kBins + std::size_t(c[0] >> kShift);
  }
  std::vector<float> body_, wall_, odds_;
};

}  // namespace choreo::vision
