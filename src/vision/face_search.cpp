// SPDX-License-Identifier: Apache-2.0
#include "vision/face_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "core/error.hpp"

namespace choreo::vision {
namespace {

constexpr double kWidths = 1.15;     // A face is searched from its width over this to its width times this.
constexpr double kBand = 1.83;       // Ratio of the sizes that one band covers; five are all, by default.
constexpr double kPartWindows = 40;  // Smallest faces, side by side, that a part holds at most.

void require(bool good, const char* name, double value, const char* range) {
  if (!good) throw usage_error(fmt::format("{} is {}", name, value), {}, fmt::format("it is {}", range));
}

}  // namespace

void FaceSearchOptions::validate() const {
  require(least_share >= 0.01 && least_share <= 0.5, "least_share", least_share, "from 0.01 to 0.5");
  require(most_share > least_share && most_share <= 1, "most_share", most_share, "above least_share, up to 1");
  require(near_frames >= 1 && near_frames <= 1000, "near_frames", near_frames, "from 1 to 1000");
  require(whole_frames >= 1 && whole_frames <= 100000, "whole_frames", whole_frames, "from 1 to 100000");
  require(lost_frames >= 1 && lost_frames <= 1000, "lost_frames", lost_frames, "from 1 to 1000");
}

FaceSearch::FaceSearch(const FaceSearchOptions& options) : options_(options) { options_.validate(); }

FaceQuery FaceSearch::near(const FaceCandidate& candidate, cv::Size size) const {
  // A window of a face is wider than the face, and it moves meanwhile.
  const double half = candidate.width * (1.3 + std::min(2.0, 2 * candidate.unseen_s));
  const cv::Point2d corner = candidate.centre - cv::Point2d(half, half);
  const int side = std::max(1, static_cast<int>(std::lround(2 * half)));
  FaceQuery query;
  query.where = cv::Rect(static_cast<int>(std::lround(corner.x)), static_cast<int>(std::lround(corner.y)), side, side) &
                cv::Rect({0, 0}, size);
  query.least_px = std::max(candidate.width / kWidths, 1.0);
  query.most_px = candidate.width * kWidths;
  constexpr std::array kLooks = {FaceLook::kFront, FaceLook::kBrightened, FaceLook::kProfile};
  query.look = kLooks[static_cast<std::size_t>(candidate.misses) % kLooks.size()];
  return query;
}

std::optional<FaceQuery> FaceSearch::step(cv::Size size, const cv::Rect& body, bool known) {
  auto whole = cv::Rect({0, 0}, size);
  if (!body.empty()) whole &= body;
  const double least = options_.least_share * size.height;
  const double most = std::min(options_.most_share * size.height, double(std::min(size.width, size.height)));
  const int bands = std::max(1, static_cast<int>(std::ceil(std::log(most / least) / std::log(kBand))));
  if (band_ < 0 || band_ >= bands) {
    band_ = bands - 1;
    part_ = 0;
  }
  FaceQuery query;
  query.where = whole;
  query.least_px = least * std::pow(kBand, band_);
  query.most_px = std::min(most, least * std::pow(kBand, band_ + 1));
  constexpr std::array kLooks = {FaceLook::kFront, FaceLook::kFront, FaceLook::kBrightened,
                                 FaceLook::kFront, FaceLook::kFront, FaceLook::kProfile};
  query.look = kLooks[round_ % kLooks.size()];
  // While nobody is known, somebody is to be found soon. Afterwards no search is to take longer than a frame is idle.
  const double windows = whole.area() / (query.least_px * query.least_px);
  const int wanted = known ? static_cast<int>(std::ceil(windows / kPartWindows)) : band_ == 0 ? 2 : 1;
  const bool across = whole.width > whole.height;
  const int length = across ? whole.width : whole.height;
  parts_ = std::clamp(wanted, 1, std::max(1, static_cast<int>(length / (2 * query.most_px))));
  // Parts overlap by a face.
  const int part = std::min(part_, parts_ - 1);
  const int share = std::min(length, static_cast<int>(std::ceil((length + (parts_ - 1) * query.most_px) / parts_) + 1));
  const int from = parts_ == 1 ? 0 : (length - share) * part / (parts_ - 1);
  (across ? query.where.width : query.where.height) = share;
  (across ? query.where.x : query.where.y) += from;
  if (++part_ >= parts_) {
    part_ = 0;
    if (--band_ < 0) ++round_;
  }
  // Where the body is narrower than such a face, it is nobody's.
  if (std::min(whole.width, whole.height) < query.least_px) return std::nullopt;
  return query;
}

std::optional<FaceQuery> FaceSearch::next(cv::Size size, const std::vector<FaceCandidate>& candidates,
                                          const cv::Rect& body) {
  ++frames_;
  if (size.empty()) return std::nullopt;
  const bool known = !candidates.empty() && candidates.front().chosen;
  const auto due = [&](std::uint64_t last, int every) {
    return last == 0 || frames_ - last >= static_cast<std::uint64_t>(every);
  };
  // Whether a new face is one is known sooner where it is looked at more often.
  const bool undecided =
      std::any_of(candidates.begin(), candidates.end(), [](const FaceCandidate& c) { return !c.confirmed; });
  const int near_frames = known && !undecided ? options_.near_frames : std::max(1, options_.near_frames / 2);
  if (!candidates.empty() && due(last_near_, near_frames)) {
    last_near_ = frames_;
    // The performer's every other time; the rest in turns, those that do not count yet before those that do.
    std::vector<FaceCandidate> others(candidates.begin() + (known ? 1 : 0), candidates.end());
    if (undecided) std::erase_if(others, [](const FaceCandidate& c) { return c.confirmed; });
    const auto turn = near_count_++;
    const std::uint64_t every = undecided ? 2 : 8;
    if (known && (others.empty() || turn % every != every - 1)) return near(candidates.front(), size);
    if (!others.empty()) return near(others[(known ? turn / every : turn) % others.size()], size);
  }
  if (due(last_step_, known ? std::max(1, options_.whole_frames / parts_) : options_.lost_frames)) {
    last_step_ = frames_;
    // Steps for which the body is too small cost no turn.
    constexpr int kMostSteps = 16;
    for (int i = 0; i < kMostSteps; ++i) {
      if (auto query = step(size, body, known)) return query;
    }
  }
  return std::nullopt;
}

}  // namespace choreo::vision
