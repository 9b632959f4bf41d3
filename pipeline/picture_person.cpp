// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "pipeline/fitted_arms.hpp"
#include "pipeline/picture_reading.hpp"
#include "pipeline/seen_arms.hpp"
#include "recognition/arm_signs.hpp"

namespace choreo::pipeline {
namespace {

using Name = vision::PersonPointName;

constexpr double kSure = 0.9;

// Somebody whom the network sees in a picture and in its mirror image, the arms fitted.
// @param region  where to look first; nothing: anywhere.
std::optional<vision::PersonLook> seen_twice(const cv::Mat& picture, vision::PersonSearch& people,
                                             const std::optional<vision::PersonRegion>& region = std::nullopt) {
  const auto look = region ? people.look(picture, *region) : people.search(picture, {});
  if (!look || look->score < kSure) return std::nullopt;
  const auto looks = looks_for_arms(picture, *look, people, 4);
  const auto sure_there = [](const auto& one) { return one.flipped && one.look.score >= kSure; };
  if (std::ranges::none_of(looks, sure_there)) return std::nullopt;
  return fitted_arms(looks, picture.size());
}

// Overlapping parts, in which who is small is larger.
std::vector<cv::Rect> parts_of(cv::Size size) {
  constexpr double kShare = 0.6;
  const int side = std::max(1, int(kShare * std::min(size.width, size.height)));
  std::vector<cv::Rect> parts;
  const auto begins = [side](int length) {
    std::vector<int> out;
    const int count = 1 + (2 * (length - side) + side - 1) / side;  // By half a side or less.
    for (int k = 0; k < count; ++k) out.push_back(count > 1 ? k * (length - side) / (count - 1) : 0);
    return out;
  };
  for (const int y : begins(size.height)) {
    for (const int x : begins(size.width)) parts.emplace_back(x, y, side, side);
  }
  return parts;
}

// Where somebody could stand of whom the detector knows nothing, as with flags before a wall of their colours: the
// network itself tells a person from none.
std::vector<vision::PersonRegion> guesses(cv::Size size) {
  constexpr double kFills = 1.1, kFillsLess = 1.4;  // Of the picture's height.
  std::vector<vision::PersonRegion> out;
  const auto guess = [&](double x, double side) {
    out.push_back({{x * size.width, 0.5 * size.height}, side * size.height, 0});
  };
  for (const double x : {0.5, 0.3, 0.7}) guess(x, kFills);
  guess(0.5, kFillsLess);
  return out;
}

// The largest whom it is sure of, in the whole picture or else in a part of it; else where it is guessed.
std::optional<vision::PersonLook> somebody_in(const cv::Mat& picture, vision::PersonSearch& people) {
  if (auto found = seen_twice(picture, people)) return found;
  std::optional<vision::PersonLook> largest;
  for (const auto& part : parts_of(picture.size())) {
    const auto look = people.search(picture(part), {});
    if (!look || look->score < kSure) continue;
    auto region = look->next;
    region.centre += cv::Point2d(part.tl());
    if (largest && largest->region.side >= region.side) continue;
    if (auto found = seen_twice(picture, people, region)) largest = std::move(found);
  }
  if (largest) return largest;
  for (const auto& guess : guesses(picture.size())) {
    const auto first = people.look(picture, guess);
    if (!first || first->score < kSure) continue;
    if (auto found = seen_twice(picture, people, first->next)) return found;
  }
  return std::nullopt;
}

}  // namespace

PictureReading read_by_network(const cv::Mat& picture, vision::PersonSearch& people, bool mirrored) {
  constexpr double kShown = 0.5;
  PictureReading out;
  out.by_network = true;
  out.why = NoSign::kNobody;
  const auto person = somebody_in(picture, people);
  if (!person) return out;
  const auto& look = *person;
  out.face = vision::face_of(look);
  out.forearms = {{look[Name::kLeftElbow].at, look[Name::kLeftWrist].at},
                  {look[Name::kRightElbow].at, look[Name::kRightWrist].at}};
  constexpr double kLikely = 127;
  out.evidence = vision::silhouette_in_picture(look, picture.size()) > kLikely;

  const auto signs = recognition::arm_signs(arm_poses(look, picture.size(), mirrored));
  out.runner_up = signs.best;
  out.confidence = signs.rest + signs.none;
  if (signs.arms_hidden) {
    out.why = NoSign::kHidden;
    out.confidence = 0;
  } else if (signs.probability >= kShown) {
    out.why.reset();
    out.sign = signs.best;
    out.runner_up = signs.next;
    out.confidence = signs.probability;
  } else {
    out.why = signs.rest > signs.none ? NoSign::kArmsHang : NoSign::kUnlikeAny;
  }
  return out;
}

}  // namespace choreo::pipeline
