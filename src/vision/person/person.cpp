// SPDX-License-Identifier: Apache-2.0
#include "vision/person/person.hpp"

#include <algorithm>
#include <cmath>

namespace choreo::vision {

double PersonLook::pixels_per_metre() const {
  cv::Point2d middle, middle_m;
  for (std::size_t k = 0; k < kPersonPoints; ++k) {
    middle += points[k].at / double(kPersonPoints);
    middle_m += cv::Point2d(metres[k].x, metres[k].y) / double(kPersonPoints);
  }
  double spread = 0, spread_m = 0;
  for (std::size_t k = 0; k < kPersonPoints; ++k) {
    const auto away = points[k].at - middle;
    const auto away_m = cv::Point2d(metres[k].x, metres[k].y) - middle_m;
    spread += away.dot(away);
    spread_m += away_m.dot(away_m);
  }
  return spread_m > 0 ? std::sqrt(spread / spread_m) : 0.0;
}

bool PersonLook::faces_away() const {
  constexpr double kMost = 110 * CV_PI / 180;
  const auto metres_of = [&](PersonPointName name) { return metres[static_cast<std::size_t>(name)]; };
  const auto ears = (metres_of(PersonPointName::kLeftEar) + metres_of(PersonPointName::kRightEar)) / 2;
  const auto nose = metres_of(PersonPointName::kNose) - ears;
  return std::abs(std::atan2(nose.x, -nose.z)) > kMost;
}

std::optional<Face> face_of(const PersonLook& look) {
  using Name = PersonPointName;
  constexpr double kSeen = 0.5;
  constexpr double kFace = 0.16;  // Metres; body::vitruvian::kFaceWidth of the 1.6 m that the network's people have.
  cv::Point2d centre;
  double seen = 1;
  for (const auto name : {Name::kLeftEye, Name::kRightEye, Name::kMouthLeft, Name::kMouthRight}) {
    centre += look[name].at / 4;
    seen = std::min({seen, look[name].visibility, look[name].presence});
  }
  const double width = kFace * look.pixels_per_metre();
  if (seen < kSeen || !(width > 0) || look.faces_away()) return std::nullopt;
  return Face{{centre.x - width / 2, centre.y - width / 2, width, width}, std::min(1.0, look.score * seen)};
}

}  // namespace choreo::vision
