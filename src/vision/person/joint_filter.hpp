// SPDX-License-Identifier: Apache-2.0
// Steadies joints that are still, and lets those pass that move.
#pragma once

#include <array>
#include <optional>

#include <opencv2/core/matx.hpp>

#include "vision/person/person.hpp"

namespace choreo::vision {

struct JointFilterOptions {
  double cutoff_hz = 1;   ///< Of a joint at rest, > 0.
  double hz_per_mps = 5;  ///< How much higher for each metre a second, >= 0.
};

/// The 1 euro filter: a low pass of first order whose cutoff grows with the speed, here of each joint in the picture
/// and in space. A joint's places are filtered together, so that no direction is slower than another.
/// @source Casiez, Roussel and Vogel, 1 Euro Filter, CHI 2012; the speed's own cutoff is theirs, 1 Hz.
class JointFilter {
 public:
  explicit JointFilter(JointFilterOptions options) : options_(options) {}

  /// @param time_s  later than the look before (asserted).
  /// @return the look with its joints filtered; the first is as it is.
  [[nodiscard]] PersonLook next(PersonLook look, double time_s);
  /// The next look is a first one.
  void forget() { before_.reset(); }

 private:
  template <int N>
  struct Low {
    cv::Vec<double, N> at{}, speed{};
  };
  struct State {
    double time_s = 0;
    std::array<Low<2>, kPersonPoints> picture{};
    std::array<Low<3>, kPersonPoints> space{};
  };

  template <int N>
  void filter(Low<N>& low, const cv::Vec<double, N>& at, double dt_s, double metre) const;

  JointFilterOptions options_;
  std::optional<State> before_;
};

}  // namespace choreo::vision
