// SPDX-License-Identifier: Apache-2.0
#include "vision/face_track.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>

#include <fmt/format.h>

#include <opencv2/core.hpp>

#include "core/error.hpp"

namespace choreo::vision {
namespace {

constexpr double kDamping_s = 0.15;    // Velocities die away in this time.
constexpr double kOthersStay_s = 10;   // Faces beside the performer's are looked for rarely.
constexpr int kCandidateMisses = 3;    // Searches in vain that end a face which does not count yet.
constexpr int kOtherMisses = 8;        // And one that counts but is not the performer's.
constexpr double kStillReach = 0.7;    // Face widths from where it was expected ...
constexpr double kReachPerSecond = 4;  // ... and for each second since.
constexpr double kReachGrows_s = 1;    // At most; or as long as a face coasts.
constexpr double kAlikeWidths = 1.5;   // Ratio.
constexpr double kMovedBy = 0.6;       // Face widths; a detector's jitter on a poster is a tenth.
constexpr double kOnBody = 0.3;        // Share of a face's box that the body mask has to cover.
constexpr double kLargerBy = 1.2;      // Before the larger one of two is another.
constexpr double kPresumed_s = 0.5;    // A face that was not seen for so long is presumed to be there.

double reach(double width, double unseen_s) {
  return width * (kStillReach + kReachPerSecond * std::max(0.0, unseen_s));
}

bool alike(double a, double b) { return a < b * kAlikeWidths && b < a * kAlikeWidths; }

// Share of the box that the mask covers; the mask may be of another size than the picture.
double share_on(const cv::Mat& mask, const cv::Rect2d& box, cv::Size size) {
  const double sx = double(mask.cols) / size.width;
  const double sy = double(mask.rows) / size.height;
  const cv::Rect scaled(static_cast<int>(std::floor(box.x * sx)), static_cast<int>(std::floor(box.y * sy)),
                        std::max(1, static_cast<int>(std::lround(box.width * sx))),
                        std::max(1, static_cast<int>(std::lround(box.height * sy))));
  const auto inside = scaled & cv::Rect({0, 0}, mask.size());
  return inside.empty() ? 0 : double(cv::countNonZero(mask(inside))) / double(inside.area());
}

}  // namespace

void FaceTrackOptions::validate() const {
  if (persistence < 1 || persistence > 100) {
    throw usage_error(fmt::format("persistence is {}", persistence), {}, "it is from 1 to 100");
  }
  if (!(coast_s >= 0 && coast_s <= 60)) {
    throw usage_error(fmt::format("coast_s is {}", coast_s), {}, "it is from 0 to 60 seconds");
  }
  if (!(hidden_s >= 0 && hidden_s <= 600)) {
    throw usage_error(fmt::format("hidden_s is {}", hidden_s), {}, "it is from 0 to 600 seconds");
  }
}

FaceTracker::FaceTracker(const FaceTrackOptions& options) : options_(options) { options_.validate(); }

cv::Point2d FaceTracker::Track::at(double time_s) const {
  const double dt = std::max(0.0, time_s - seen_s);
  return centre + velocity * (kDamping_s * (1 - std::exp(-dt / kDamping_s)));
}

bool FaceTracker::counts(const Track& track) const {
  return track.hits >= options_.persistence && (track.on_body < 0 || track.on_body >= kOnBody);
}

double FaceTracker::stays_s(const Track& track) const {
  return track.covered ? std::max(options_.coast_s, options_.hidden_s) : options_.coast_s;
}

bool FaceTracker::may_be_chosen(const Track& track) const {
  if (!counts(track)) return false;
  if (track.on_body >= kOnBody || track.moved || !lost_s_) return true;
  // Nothing is known of the body, and it has not moved. It may be the face that was lost, seen again where that can
  // have gone, or somebody who came in since: then it was not there before.
  const double gone_s = track.first_s - *lost_s_;
  if (gone_s < 0) return false;
  const bool near = cv::norm(track.first - lost_at_) <= reach(lost_width_, gone_s) && alike(track.width, lost_width_);
  return near || track.hits >= 2 * options_.persistence;
}

void FaceTracker::match(const FaceSighting& sighting, cv::Size size) {
  struct Pair {
    double distance;  // In units of what is allowed.
    std::size_t face, track;
  };
  const auto& faces = sighting.faces;
  std::vector<Pair> pairs;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto& box = faces[f].box;
    const cv::Point2d centre = (box.tl() + box.br()) / 2;
    for (std::size_t t = 0; t < tracks_.size(); ++t) {
      const auto& track = tracks_[t];
      // Nobody goes far while they are hidden behind their own arm.
      const double unseen_s = std::min(sighting.time_s - track.seen_s, std::max(options_.coast_s, kReachGrows_s));
      const double allowed = reach(track.width, unseen_s);
      const double distance = cv::norm(centre - track.at(sighting.time_s)) / allowed;
      if (distance <= 1 && alike(box.width, track.width)) pairs.push_back({distance, f, t});
    }
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    return std::tie(a.distance, a.face, a.track) < std::tie(b.distance, b.face, b.track);
  });
  std::vector<char> used(faces.size(), 0);
  std::vector<char> found(tracks_.size(), 0);
  const auto on_body = [&](const cv::Rect2d& box) {
    return sighting.body.empty() ? -1.0 : share_on(sighting.body, box, size);
  };
  for (const auto& pair : pairs) {
    if (used[pair.face] != 0 || found[pair.track] != 0) continue;
    used[pair.face] = found[pair.track] = 1;
    const auto& face = faces[pair.face];
    auto& track = tracks_[pair.track];
    const cv::Point2d seen = (face.box.tl() + face.box.br()) / 2;
    const double dt = sighting.time_s - track.seen_s;
    // An alpha-beta filter.
    const auto expected = track.at(sighting.time_s);
    const auto residual = seen - expected;
    if (dt > 0) {
      track.velocity = track.velocity * std::exp(-dt / kDamping_s) + residual * (0.3 / std::max(dt, 1e-3));
      track.seen_s = sighting.time_s;
    }
    track.centre = expected + residual * 0.7;
    track.width += 0.3 * (face.box.width - track.width);
    track.confidence += 0.5 * (face.confidence - track.confidence);
    ++track.hits;
    track.misses = 0;
    track.covered = false;
    track.moved = track.moved || cv::norm(track.centre - track.first) > kMovedBy * track.width;
    if (const double share = on_body(face.box); share >= 0) {
      track.on_body = track.on_body < 0 ? share : track.on_body + 0.4 * (share - track.on_body);
    }
  }
  const auto& query = sighting.query;
  for (std::size_t t = 0; t < tracks_.size(); ++t) {
    auto& track = tracks_[t];
    const bool searched = cv::Rect2d(query.where).contains(track.at(sighting.time_s)) &&
                          query.least_px <= track.width && track.width <= query.most_px;
    if (found[t] != 0) continue;
    if (searched) ++track.misses;
    const auto centre = track.at(sighting.time_s);
    const cv::Rect2d box(centre.x - track.width / 2, centre.y - track.width / 2, track.width, track.width);
    track.covered = track.on_body >= kOnBody && on_body(box) >= kOnBody;
  }
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto& face = faces[f];
    if (used[f] != 0 || !(face.box.width > 0)) continue;
    Track track;
    track.id = next_id_++;
    track.first = track.centre = (face.box.tl() + face.box.br()) / 2;
    track.width = face.box.width;
    track.confidence = face.confidence;
    track.first_s = track.seen_s = sighting.time_s;
    track.on_body = on_body(face.box);
    track.hits = 1;
    // A second box over a face that was matched is the same face seen badly.
    const bool doubled = std::any_of(tracks_.begin(), tracks_.end(), [&](const Track& other) {
      return cv::norm(other.at(sighting.time_s) - track.centre) < 0.5 * std::max(other.width, track.width);
    });
    if (!doubled) tracks_.push_back(track);
  }
}

void FaceTracker::forget(double time_s, cv::Size size) {
  const cv::Rect2d picture({0, 0}, cv::Size2d(size));
  const auto gone = [&](const Track& track) {
    const double unseen_s = time_s - track.seen_s;
    if (!picture.contains(track.at(time_s))) return true;
    if (track.id == chosen_) return unseen_s > stays_s(track);
    if (track.hits < options_.persistence) return track.misses >= kCandidateMisses || unseen_s > kOthersStay_s;
    return track.misses >= kOtherMisses || unseen_s > kOthersStay_s;
  };
  for (const auto& track : tracks_) {
    if (track.id != chosen_ || !gone(track)) continue;
    lost_s_ = track.seen_s;
    lost_at_ = track.centre;
    lost_width_ = track.width;
    chosen_ = 0;
    break;
  }
  tracks_.erase(std::remove_if(tracks_.begin(), tracks_.end(), gone), tracks_.end());
}

void FaceTracker::choose(double time_s) {
  const auto current = std::find_if(tracks_.begin(), tracks_.end(), [&](const Track& t) { return t.id == chosen_; });
  // What it shows for being the performer's.
  const auto evidence = [](const Track& t) { return t.on_body >= kOnBody ? 2 : t.moved ? 1 : 0; };
  const bool kept = current != tracks_.end() && counts(*current);
  const Track* best = kept ? &*current : nullptr;
  for (const auto& track : tracks_) {
    if (track.id == chosen_ || !may_be_chosen(track)) continue;
    // One that is not seen just now takes nobody's place.
    if (time_s - track.seen_s > options_.coast_s) continue;
    if (best == nullptr) {
      best = &track;
      continue;
    }
    const int more = evidence(track) - evidence(*best);
    const bool against_current = kept && best == &*current;
    bool better = false;
    if (against_current) {
      const bool presumed = time_s - best->seen_s > kPresumed_s && track.seen_s > best->seen_s + kPresumed_s;
      better = (evidence(*best) == 0 && more > 0) || (presumed && track.on_body >= kOnBody) ||
               (options_.choose == FaceChoice::kLargest && more >= 0 && track.width > kLargerBy * best->width);
    } else {
      better = more > 0 || (more == 0 && track.width > best->width);
    }
    if (better) best = &track;
  }
  const auto before = chosen_;
  chosen_ = best != nullptr ? best->id : 0;
  if (before != 0 && chosen_ == 0 && current != tracks_.end()) {
    lost_s_ = current->seen_s;
    lost_at_ = current->centre;
    lost_width_ = current->width;
  }
  if (chosen_ != 0) lost_s_.reset();
}

FaceReport FaceTracker::update(double time_s, cv::Size size, const FaceSighting* sighting) {
  time_s_ = time_s;
  if (sighting != nullptr) match(*sighting, size);
  forget(time_s, size);
  choose(time_s);
  FaceReport report;
  for (const auto& track : tracks_) {
    if (!counts(track)) continue;
    ++report.in_sight;
    if (track.id != chosen_) continue;
    const double unseen_s = std::max(0.0, time_s - track.seen_s);
    // Half of it is gone when the face is.
    const double stays = stays_s(track);
    const double fade = stays > 0 ? 1 - 0.5 * std::min(1.0, unseen_s / stays) : 1;
    report.face = TrackedFace{track.at(time_s), track.width, track.confidence * fade, time_s - track.first_s, unseen_s};
  }
  return report;
}

std::vector<FaceCandidate> FaceTracker::candidates() const {
  std::vector<FaceCandidate> all;
  for (const auto& track : tracks_) {
    all.push_back({track.id, track.at(time_s_), track.width, std::max(0.0, time_s_ - track.seen_s), track.misses,
                   track.hits >= options_.persistence, track.id == chosen_});
  }
  std::stable_partition(all.begin(), all.end(), [](const FaceCandidate& c) { return c.chosen; });
  return all;
}

}  // namespace choreo::vision
