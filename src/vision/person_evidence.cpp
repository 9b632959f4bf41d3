// SPDX-License-Identifier: Apache-2.0
#include "vision/person_evidence.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace choreo::vision {

void draw(const std::vector<PersonEvidence::Limb>& limbs, double doubt_px, cv::Mat& out) {
  constexpr int kThickest = 32767;  // OpenCV's.
  for (const auto& limb : limbs) {
    const int thickness = std::max(1, cvRound(2 * (limb.radius + doubt_px)));
    cv::line(out, limb.from, limb.to, 255, std::min(thickness, kThickest));  // Its ends are round.
  }
}

cv::Mat possible(const PersonEvidence& person, cv::Size size) {
  if (person.likely.empty()) return cv::Mat::zeros(size, CV_8UC1);
  cv::Mat out;
  constexpr double kPossible = 25;  // Of 255: one in ten.
  const int side = 2 * int(std::lround(person.doubt_px + kPersonReach * size.height)) + 1;
  cv::dilate(person.likely > kPossible, out, cv::getStructuringElement(cv::MORPH_RECT, {side, side}));
  draw(person.limbs, person.doubt_px, out);
  draw(person.held, person.doubt_px, out);
  return out;
}

cv::Mat others_alone(const PersonEvidence& person, cv::Size size) {
  constexpr double kLikely = 127;
  if (person.others.empty()) return cv::Mat::zeros(size, CV_8UC1);
  if (person.likely.empty()) return person.about_others;
  cv::Mat persons = person.likely > kLikely;
  draw(person.limbs, 0, persons);
  return (person.about_others & ~persons) | ((person.others > kLikely) & (person.others > person.likely));
}

PersonEvidence together(PersonEvidence person, const PersonEvidence& other) {
  if (other.likely.empty()) return person;
  if (person.likely.empty()) return other;
  cv::Mat likely;
  cv::max(person.likely, other.likely, likely);
  person.likely = likely;
  person.doubt_px = std::max(person.doubt_px, other.doubt_px);
  person.limbs.insert(person.limbs.end(), other.limbs.begin(), other.limbs.end());
  person.held.insert(person.held.end(), other.held.begin(), other.held.end());
  return person;
}

PersonEvidence brought_back(const PersonEvidence& person, const CameraShift& shift) {
  if (person.likely.empty() || shift == kNoShift) return person;
  auto out = person;
  const cv::Mat nothing = cv::Mat::zeros(person.likely.size(), CV_8UC1);
  out.likely = brought_back(person.likely, shift, nothing);
  if (!person.others.empty()) {
    out.others = brought_back(person.others, shift, nothing);
    out.about_others = brought_back(person.about_others, shift, nothing) > 0;
  }
  CameraShift back;
  cv::invertAffineTransform(shift, back);
  for (auto* limbs : {&out.limbs, &out.held}) {
    for (auto& limb : *limbs) {
      for (auto* end : {&limb.from, &limb.to}) {
        const cv::Vec2d to = back * cv::Vec3d(end->x, end->y, 1);
        *end = {to[0], to[1]};
      }
    }
  }
  return out;
}

}  // namespace choreo::vision
