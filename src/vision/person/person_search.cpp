// SPDX-License-Identifier: Apache-2.0
#include "vision/person/person_search.hpp"

#include <algorithm>

namespace choreo::vision {
namespace {

constexpr int kTurns = 3;

// The whole picture, or the square at either end of it.
cv::Rect part_of(cv::Size size, int turn) {
  const int side = std::min(size.width, size.height);
  switch (turn % kTurns) {
    case 1:
      return {0, 0, side, side};
    case 2:
      return {size.width - side, size.height - side, side, side};
    default:
      return {{0, 0}, size};
  }
}

}  // namespace

void PersonTrack::update(const std::optional<PersonLook>& look) {
  if (look) {
    region_ = look->next;
  } else {
    region_.reset();
    turn_ = (turn_ + 1) % kTurns;
  }
}

std::optional<PersonLook> PersonSearch::found(const cv::Mat& picture, int turn) {
  const auto part = part_of(picture.size(), turn);
  const auto people = detector_.detect(picture(part));
  if (people.empty()) return std::nullopt;
  auto region = std::ranges::max_element(people, {}, [](const auto& p) { return p.region.side; })->region;
  region.centre += cv::Point2d(part.tl());
  const auto first = network_.look(picture, region);
  if (first.score < PersonTrack::kLeastScore) return std::nullopt;
  auto look = network_.look(picture, first.next);
  if (look.score < PersonTrack::kLeastScore) return std::nullopt;
  return look;
}

std::optional<PersonLook> PersonSearch::search(const cv::Mat& picture, const PersonQuery& query) {
  if (query.region) {
    auto look = network_.look(picture, *query.region);
    if (look.score >= PersonTrack::kLeastScore) return look;
  }
  for (int turn = query.turn.value_or(0); turn < kTurns; ++turn) {
    auto look = found(picture, turn);
    if (look || query.turn) return look;
  }
  return std::nullopt;
}

}  // namespace choreo::vision
