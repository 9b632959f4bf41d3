// SPDX-License-Identifier: Apache-2.0
#include "pipeline/stages/person_stage.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "core/error.hpp"
#include "pipeline/fitted_arms.hpp"

namespace choreo::pipeline {
namespace {

// From pixels of one picture to those of another of the same shape.
vision::PersonLook scaled(vision::PersonLook look, double factor) {
  const auto moved = [factor](cv::Point2d p) { return (p + cv::Point2d(0.5, 0.5)) * factor - cv::Point2d(0.5, 0.5); };
  const auto change = [&](vision::PersonRegion& region) {
    region.centre = moved(region.centre);
    region.side *= factor;
  };
  for (auto& point : look.points) {
    point.at = moved(point.at);
    point.depth *= factor;
  }
  change(look.region);
  change(look.next);
  return look;
}

// How far the joint went that went farthest, of those that are seen in both.
double fastest(const vision::PersonLook& a, const vision::PersonLook& b) {
  constexpr double kSeen = 0.5;
  double most = 0;
  for (std::size_t k = 0; k < a.points.size(); ++k) {
    if (a.points[k].visibility < kSeen || b.points[k].visibility < kSeen) continue;
    const auto way = b.points[k].at - a.points[k].at;
    most = std::max(most, std::hypot(way.x, way.y));
  }
  return most;
}

std::shared_ptr<PersonSighting> sighting(vision::PersonLook look, Nanoseconds time, devices::FramePtr frame,
                                         const std::shared_ptr<const PersonSighting>& before) {
  auto now = std::make_shared<PersonSighting>(PersonSighting{std::move(look), time, std::move(frame), {}});
  if (before && time > before->time) now->speed = fastest(before->look, now->look) / to_seconds(time - before->time);
  return now;
}

// Whether this frame is the first one at or behind the next time for a look, which then is a period later. Frames come
// when they come: half a millisecond early is in time.
bool is_time(Nanoseconds time, double per_s, std::optional<Nanoseconds>& next) {
  constexpr auto kEarly = std::chrono::microseconds(500);
  const auto period = Nanoseconds(std::llround(1e9 / per_s));
  if (next && time + kEarly < *next) return false;
  // What was missed is not made up for.
  next = next && time < *next + period ? *next + period : time + period;
  return true;
}

}  // namespace

// Written by the search, and read when it is done.
struct PersonStage::Look {
  devices::FramePtr frame;
  Nanoseconds time{0};
  vision::PersonQuery query;
  std::optional<vision::OthersQuery> others_query;
  std::optional<vision::PersonLook> seen;
  std::vector<std::optional<vision::PersonLook>> others_seen;
  bool for_arms = false;
  std::optional<vision::PersonLook> arms;
};

void PersonStageOptions::validate() const {
  if (looks_per_s < 0.1 || looks_per_s > 1000) {
    throw usage_error(fmt::format("looks_per_s is {}", looks_per_s), {}, "it is from 0.1 to 1000");
  }
  if (seeks_per_s && (*seeks_per_s < 0.1 || *seeks_per_s > 1000)) {
    throw usage_error(fmt::format("seeks_per_s is {}", *seeks_per_s), {}, "it is from 0.1 to 1000");
  }
  if (arms_per_s && (*arms_per_s < 0.1 || *arms_per_s > 1000)) {
    throw usage_error(fmt::format("arms_per_s is {}", *arms_per_s), {}, "it is from 0.1 to 1000");
  }
  if (arm_looks < 1 || arm_looks > 4) throw usage_error(fmt::format("arm_looks is {}", arm_looks), {}, "it is 1 to 4");
  if (delay_s < 0 || delay_s > 2) throw usage_error(fmt::format("delay_s is {}", delay_s), {}, "it is from 0 to 2");
}

PersonStage::PersonStage(vision::PersonSearch search, PersonStageOptions options)
    : options_(std::move(options)),
      search_(std::move(search)),
      track_(options_.delay_s > 0 ? vision::PersonTrack::Seeks::kInTurns : vision::PersonTrack::Seeks::kEverywhere),
      others_(options_.delay_s > 0 ? vision::PersonTrack::Seeks::kInTurns : vision::PersonTrack::Seeks::kEverywhere) {
  options_.validate();
  if (options_.smooth) filter_.emplace(*options_.smooth);
  if (options_.delay_s > 0) beside_.emplace("person-search", options_.waits, SearchBeside::WhenLate::kDefer);
}

void PersonStage::take_effect(const std::shared_ptr<Look>& look, Observation& observation) {
  ++looks_;
  observation.looked = look->time;
  track_.update(look->seen);
  const auto before = std::exchange(last_, nullptr);
  const auto those_before = std::exchange(others_seen_, {});
  constexpr auto kOthersWait = std::chrono::seconds(1);  // For the person to be found again, who is none of them.
  if (!look->seen) {
    if (filter_) filter_->forget();
    if (look->time - seen_at_ <= kOthersWait) {
      others_seen_ = those_before;
    } else {
      others_ = vision::OthersTrack(others_.seeks());
    }
    return;
  }
  ++seen_;
  seen_at_ = look->time;
  const bool followed = look->query.region && *look->query.region == look->seen->region;
  if (filter_ && !followed) filter_->forget();
  if (!before && options_.seeks_per_s) next_.reset();  // Seeking is over.
  const auto& picture = observation.picture.empty() ? observation.frame->bgr : observation.picture;
  const double factor = picture.empty() ? 1.0 : double(picture.cols) / look->frame->bgr.cols;
  const auto now =
      sighting(scaled(*std::move(look->seen), factor), look->time, look->frame, followed ? before : nullptr);
  if (look->arms) now->arms = scaled(*std::move(look->arms), factor);
  if (filter_) now->smooth = filter_->next(now->look, to_seconds(now->time));
  last_ = now;
  if (look->others_query) others_.update(*look->others_query, look->others_seen, look->time.count());
  // Who moves far between two looks has no speed.
  for (const auto& [seen, when] : others_.known()) {
    const auto scaled_one = scaled(seen, factor);
    const auto earlier = std::ranges::find_if(
        those_before, [&](const auto& one) { return vision::show_the_same(one->look, scaled_one); });
    if (earlier != those_before.end() && (*earlier)->time.count() == when) {
      others_seen_.push_back(*earlier);
    } else {
      others_seen_.push_back(
          sighting(scaled_one, Nanoseconds(when), {}, earlier != those_before.end() ? *earlier : nullptr));
    }
  }
}

void PersonStage::process(Observation& observation) {
  if (beside_) {
    const auto due = beside_->begin_frame(observation.time.count(), observation.frame->late_person);
    if (due == SearchBeside::Due::kDone) {
      take_effect(std::exchange(pending_, nullptr), observation);
    } else if (due == SearchBeside::Due::kLate && options_.on_late) {
      options_.on_late(observation.frame->sequence);
    }
  }
  const double per_s = last_ ? options_.looks_per_s : options_.seeks_per_s.value_or(options_.looks_per_s);
  if (!pending_ && !observation.frame->bgr.empty() && is_time(observation.time, per_s, next_)) {
    auto look = std::make_shared<Look>(Look{observation.frame, observation.time, track_.next(), {}, {}, {}, false, {}});
    look->for_arms = options_.arms_per_s && is_time(observation.time, *options_.arms_per_s, next_arms_);
    for (const auto& other : others_.known()) look->query.others.push_back(other.look);
    if (options_.others && (last_ || !beside_)) look->others_query = others_.next();
    const bool at_once = !beside_ || (options_.first_at_once && !std::exchange(asked_, true));
    const auto search = [this, look] {
      try {
        look->seen = search_.search(look->frame->bgr, look->query);
        if (look->seen && look->for_arms) {
          const auto& picture = look->frame->bgr;
          look->arms = fitted_arms(looks_for_arms(picture, *look->seen, search_, options_.arm_looks), picture.size());
        }
        if (look->seen && look->others_query) {
          look->others_seen = search_.search_others(look->frame->bgr, *look->others_query, look->seen);
        }
      } catch (const cv::Exception& error) {
        throw failure(fmt::format("looking for a person failed: {}", error.err));
      }
    };
    if (!at_once) {
      pending_ = look;
      beside_->ask(search, (observation.time + from_seconds(options_.delay_s)).count());
    } else {
      search();
      take_effect(look, observation);
    }
  }
  observation.person = last_;
  observation.others = others_seen_;
}

}  // namespace choreo::pipeline
