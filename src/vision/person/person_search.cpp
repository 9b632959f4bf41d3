// SPDX-License-Identifier: Apache-2.0
#include "vision/person/person_search.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <utility>

#include <opencv2/imgproc.hpp>

namespace choreo::vision {
namespace {

constexpr int kSquares = 3;  // The whole picture and the square at either end of it; then what moves.
constexpr int kTurns = 4;

cv::Rect part_of(cv::Size size, int turn) {
  const int side = std::min(size.width, size.height);
  switch (turn) {
    case 1:
      return {0, 0, side, side};
    case 2:
      return {size.width - side, size.height - side, side, side};
    default:
      return {{0, 0}, size};
  }
}

// The parts to the left and to the right of somebody's box, in which those who stand there are larger.
std::pair<cv::Rect, cv::Rect> beside(const cv::Rect& box, cv::Size size) {
  constexpr double kSide = 0.8;  // Of the picture's height.
  const int side = int(std::lround(kSide * size.height));
  const int top = std::clamp(box.y + box.height / 2 - side / 2, 0, size.height - side);
  const cv::Rect whole({0, 0}, size);
  return {cv::Rect(box.x + box.width / 4 - side, top, side, side) & whole,
          cv::Rect(box.br().x - box.width / 4, top, side, side) & whole};
}

// A picture small enough that what moves in it is a person, and no noise.
cv::Mat small_of(const cv::Mat& picture) {
  constexpr double kHeight = 48;
  const double factor = std::min(1.0, kHeight / picture.rows);
  const cv::Size size(std::max(1, cvRound(factor * picture.cols)), std::max(1, cvRound(factor * picture.rows)));
  cv::Mat grey, out;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  cv::resize(grey, out, size, 0, 0, cv::INTER_AREA);
  return out;
}

// A square about the largest thing that differs; nothing where that is about the whole picture.
std::optional<cv::Rect> what_moved(const cv::Mat& before, const cv::Mat& now, cv::Size size) {
  constexpr double kDiffers = 12;
  constexpr double kRoom = 1.5;                // Beside what moved there is more of a person.
  constexpr double kMost = 0.8, kLeast = 0.4;  // Of the picture's height.
  if (before.size() != now.size()) return std::nullopt;
  cv::Mat changed, labels, stats, centroids;
  cv::absdiff(before, now, changed);
  cv::dilate(changed > kDiffers, changed, cv::Mat());
  const int count = cv::connectedComponentsWithStats(changed, labels, stats, centroids);
  cv::Rect largest;
  for (int k = 1; k < count; ++k) {
    const cv::Rect box(stats.at<int>(k, cv::CC_STAT_LEFT), stats.at<int>(k, cv::CC_STAT_TOP),
                       stats.at<int>(k, cv::CC_STAT_WIDTH), stats.at<int>(k, cv::CC_STAT_HEIGHT));
    if (box.area() > largest.area()) largest = box;
  }
  const double scale = double(size.height) / now.rows;
  const double side = std::max(kRoom * scale * std::max(largest.width, largest.height), kLeast * size.height);
  if (largest.empty() || side > kMost * size.height || side > size.width) return std::nullopt;
  const int pixels = int(std::lround(side));
  const cv::Point2d middle = scale * cv::Point2d(largest.tl() + largest.br()) / 2;
  const auto begin = [&](double at, int most) {
    return int(std::clamp(std::lround(at - side / 2), 0L, long(most - pixels)));
  };
  return cv::Rect(begin(middle.x, size.width), begin(middle.y, size.height), pixels, pixels);
}

}  // namespace

bool show_the_same(const PersonLook& a, const PersonLook& b) {
  constexpr double kSeen = 0.5;
  constexpr double kSame = 1 / 12.0;  // Of the region's side.
  double sum = 0;
  int count = 0;
  for (std::size_t k = 0; k < a.points.size(); ++k) {
    if (a.points[k].visibility < kSeen || b.points[k].visibility < kSeen) continue;
    const auto apart = a.points[k].at - b.points[k].at;
    sum += std::hypot(apart.x, apart.y);
    ++count;
  }
  if (count == 0) return cv::norm(a.region.centre - b.region.centre) < a.region.side / 4;
  return sum / count < kSame * std::min(a.region.side, b.region.side);
}

void PersonTrack::update(const std::optional<PersonLook>& look) {
  if (look) {
    region_ = look->next;
  } else {
    region_.reset();
    turn_ = (turn_ + 1) % kTurns;
  }
}

std::vector<PersonRegion> PersonSearch::detected(const cv::Mat& picture, cv::Rect part) {
  std::vector<PersonRegion> out;
  for (const auto& person : detector_.detect(picture(part))) {
    out.push_back(person.region);
    out.back().centre += cv::Point2d(part.tl());
  }
  return out;
}

std::optional<PersonLook> PersonSearch::twice(const cv::Mat& picture, const PersonRegion& region) {
  const auto first = look(picture, region);
  return first ? look(picture, first->next) : std::nullopt;
}

std::optional<PersonLook> PersonSearch::largest(const cv::Mat& picture, const PersonQuery& query,
                                                const cv::Mat& before) {
  for (int turn = 0; turn < kTurns; ++turn) {
    if (query.turn && turn != *query.turn) continue;
    auto part = turn < kSquares ? part_of(picture.size(), turn) : what_moved(before, small_, picture.size());
    if (!part && query.turn) part = part_of(picture.size(), 0);  // No turn is lost.
    if (!part) continue;
    auto people = detected(picture, *part);
    std::ranges::stable_sort(people, std::ranges::greater(), &PersonRegion::side);
    for (const auto& region : people) {
      auto look = twice(picture, region);
      if (look && std::ranges::none_of(query.others, [&](const auto& one) { return show_the_same(*look, one); })) {
        return look;
      }
    }
  }
  return std::nullopt;
}

std::optional<PersonLook> PersonSearch::look(const cv::Mat& picture, const PersonRegion& region) {
  auto look = network_.look(picture, region);
  return look.score >= PersonTrack::kLeastScore ? std::optional(std::move(look)) : std::nullopt;
}

std::optional<PersonLook> PersonSearch::search(const cv::Mat& picture, const PersonQuery& query) {
  const cv::Mat before = std::exchange(small_, small_of(picture));
  if (query.region) {
    if (auto seen = look(picture, *query.region)) return seen;
  }
  auto first = largest(picture, query, before);
  if (!first || choice_ == PersonChoice::kLargest) return first;
  auto people = search_others(picture, {.known = {}, .looked = {}, .seek = true}, first);
  people.push_back(std::move(first));
  return *std::ranges::max_element(people, {}, [&](const std::optional<PersonLook>& look) {
    const double x = look->region.centre.x;
    if (choice_ == PersonChoice::kMiddle) return -std::abs(x - (picture.cols - 1) / 2.0);
    return choice_ == PersonChoice::kLeft ? -x : x;
  });
}

OthersQuery OthersTrack::next() const {
  OthersQuery query;
  for (const auto& other : known_) query.known.push_back(other.look);
  if (seeks_ == PersonTrack::Seeks::kEverywhere) {
    constexpr int kEvery = 15;  // Looks, half a second of film.
    for (std::size_t k = 0; k < known_.size(); ++k) query.looked.push_back(k);
    query.seek = looks_ % kEvery == 0;
    return query;
  }
  const int turn = looks_ % (int(known_.size()) + 1);
  query.seek = turn == 0;
  if (query.seek) {
    query.turn = sought_;
  } else {
    query.looked.push_back(std::size_t(turn - 1));
  }
  return query;
}

void OthersTrack::update(const OthersQuery& query, const std::vector<std::optional<PersonLook>>& looks,
                         std::int64_t when) {
  ++looks_;
  if (query.seek) ++sought_;
  std::vector<bool> gone(known_.size());
  for (std::size_t k = 0; k < looks.size(); ++k) {
    if (k >= query.looked.size()) {
      if (looks[k] && known_.size() < kMost) known_.push_back({*looks[k], when});
    } else if (looks[k]) {
      known_[query.looked[k]] = {*looks[k], when};
    } else {
      gone[query.looked[k]] = true;
    }
  }
  for (std::size_t k = gone.size(); k-- > 0;) {
    if (!gone[k]) continue;
    known_.erase(known_.begin() + std::ptrdiff_t(k));
    if (seeks_ == PersonTrack::Seeks::kEverywhere) looks_ = 0;  // They are searched for at once.
  }
}

std::vector<std::optional<PersonLook>> PersonSearch::search_others(const cv::Mat& picture, const OthersQuery& query,
                                                                   const std::optional<PersonLook>& person) {
  std::vector<std::optional<PersonLook>> out;
  std::vector<PersonLook> seen;  // Of this picture.
  if (person) seen.push_back(*person);
  const auto is_known = [&](const PersonLook& look) {
    return std::ranges::any_of(seen, [&](const auto& one) { return show_the_same(look, one); });
  };
  for (const auto k : query.looked) {
    auto look = network_.look(picture, query.known[k].next);
    if (look.score < PersonTrack::kLeastScore || is_known(look)) {
      out.emplace_back();
    } else {
      seen.push_back(look);
      out.emplace_back(std::move(look));
    }
  }
  if (!query.seek) return out;
  // The detector tells one of two who are near each other: whoever is known is painted over, and beside them is looked
  // more closely.
  cv::Mat rest = picture.clone();
  std::vector<cv::Rect> parts;
  for (int turn = 0; turn < kSquares; ++turn) parts.push_back(part_of(picture.size(), turn));
  const auto leave_out = [&](const PersonLook& look) {
    constexpr double kLikely = 127;
    const auto box = cv::boundingRect(silhouette_in_picture(look, picture.size()) > kLikely);
    if (box.empty()) return;
    rest(box).setTo(cv::Scalar::all(kLikely));
    const auto [left, right] = beside(box, picture.size());
    for (const auto& part : {left, right}) {
      if (!part.empty()) parts.push_back(part);
    }
  };
  // Those of whom it was not their turn are where they were.
  for (std::size_t k = 0; k < query.known.size(); ++k) {
    if (std::ranges::find(query.looked, k) == query.looked.end()) seen.push_back(query.known[k]);
  }
  for (const auto& look : seen) leave_out(look);
  const auto most = OthersTrack::kMost + (person ? 1 : 0);
  const auto only = std::size_t(query.turn.value_or(0)) % parts.size();
  for (std::size_t k = 0; k < parts.size(); ++k) {
    if (query.turn && k != only) continue;
    for (const auto& region : detected(rest, parts[k])) {
      if (seen.size() >= most) return out;
      const auto near = [&](const PersonLook& look) {
        return cv::norm(look.next.centre - region.centre) < std::min(look.next.side, region.side) / 8;
      };
      // A look costs as much as a search.
      if (std::ranges::any_of(seen, near)) continue;
      auto look = twice(picture, region);
      if (!look || is_known(*look)) continue;
      seen.push_back(*look);
      leave_out(*look);
      out.emplace_back(std::move(look));
    }
  }
  return out;
}

}  // namespace choreo::vision
