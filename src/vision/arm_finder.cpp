// SPDX-License-Identifier: Apache-2.0
#include "vision/arm_finder.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "core/error.hpp"
#include "vision/difference.hpp"
#include "vision/face_region.hpp"

namespace choreo::vision {
namespace {

// What a neckline can show, between the arms, in face widths.
constexpr double kChestHalfWidth = 1.0;
constexpr double kChestEnd = 2.2;

constexpr double kSlack = 1.3;       // On reach: nobody is exactly Vitruvian, and a small face is off by a sixth.
constexpr double kWhole = 0.95;      // Share of an arm's pixels that one shoulder reaches.
constexpr double kMostly = 0.7;      // Share of an arm's pixels that some shoulder reaches.
constexpr double kTwoArms = 1.6;     // Areas of one arm from which on a region holds two.
constexpr double kStillTwo = 1.2;    // Likewise where it did so just before.
constexpr double kWholeArm = 2.6;    // Face widths squared: an arm bare from the shoulder on is not larger.
constexpr double kPiece = 0.6;       // Areas of one arm under which a region may be a piece of one.
constexpr double kThin = 0.45;       // Root of the least variance of an arm, bent or not, in face widths.
constexpr double kLearn_s = 0.65;    // Time constant of the typical area.
constexpr double kMostStep_s = 0.2;  // What one frame can add to that time, after a gap.
constexpr std::size_t kMostCandidates = 12;

void check(double value, double least, double most, std::string_view name) {
  if (value >= least && value <= most) return;
  throw usage_error(fmt::format("'{}' is not from {} to {}", value, least, most), fmt::format("arms.{}", name));
}

// The whole pixels from `low` to `high` within [0, limit).
std::pair<int, int> pixels(double low, double high, int limit) {
  return {std::clamp(int(std::ceil(low)), 0, limit), std::clamp(int(std::floor(high)) + 1, 0, limit)};
}

// The least eigenvalue of the covariance, px^2.
double least_variance(const Moments& m) {
  return ((m.mu20 + m.mu02) / 2 - std::hypot((m.mu20 - m.mu02) / 2, m.mu11)) / m.m00;
}

double distance(cv::Point2d a, cv::Point2d b) { return std::hypot(a.x - b.x, a.y - b.y); }

// From a run to a point, 0 within it.
double distance_to(const Run& run, cv::Point2d p) {
  return std::hypot(std::max({run.from - p.x, p.x - (run.to - 1), 0.0}), run.y - p.y);
}

}  // namespace

void ArmOptions::validate() const {
  check(min_probability, 0.01, 1, "min_probability");
  check(anneal, 0, 0.3, "anneal");
  check(reach, 1, 10, "reach");
  check(shoulder_aside, 0, 5, "shoulder_aside");
  check(shoulder_below, 0, 5, "shoulder_below");
  check(typical_arm, 0.1, 10, "typical_arm");
  check(least_arm, 0.02, 5, "least_arm");
  check(largest_arm, least_arm, 30, "largest_arm");
  check(least_piece, 0, least_arm, "least_piece");
  check(piece_gap, 0, 3, "piece_gap");
  check(memory_s, 0, 10, "memory_s");
}

// A region that may be an arm.
struct ArmFinder::Candidate {
  Blob blob;
  std::vector<Run> runs;
  bool at_face = false;
  bool pieced = false;

  [[nodiscard]] double area() const { return blob.moments.m00; }
};

// One picture with its face.
class ArmFinder::Search {
 public:
  Search(const ArmOptions& options, const TrackedFace& face, double typical)
      : options_(options), face_(face), unit_(face.width), typical_(typical) {}

  [[nodiscard]] std::vector<Candidate> candidates(const cv::Mat& posterior, const cv::Mat& body) const;

  [[nodiscard]] bool is_arm(const Candidate& c) const {
    return in_areas(c) >= options_.least_arm && in_areas(c) <= options_.largest_arm && whole(c);
  }
  // Whether it is as large, or reaches as far, as no single arm. One bare up to its shoulder is larger than a forearm.
  [[nodiscard]] bool holds_two(const Candidate& c, double areas) const {
    const bool large = in_areas(c) > areas * typical_ && !(is_arm(c) && in_areas(c) < kWholeArm && at_one_shoulder(c));
    return (large || !whole(c)) && in_areas(c) <= 2 * options_.largest_arm && in_areas(c) >= typical_;
  }
  [[nodiscard]] double in_areas(const Candidate& c) const { return c.area() / (unit_ * unit_); }
  // As a share of an arm's, at most 1.
  [[nodiscard]] double size(const Candidate& c) const { return std::min(1.0, in_areas(c) / typical_); }
  [[nodiscard]] double typical() const { return typical_; }
  [[nodiscard]] cv::Point2d place(const Candidate& c) const {
    return (c.blob.moments.centroid - face_.centre) * (1 / unit_);
  }
  // Whether a point, in face widths from the face, lies on the region or beside it.
  [[nodiscard]] bool covers(const Candidate& c, cv::Point2d point) const {
    return near(c, face_.centre + point * unit_, 0.4);
  }

 private:
  [[nodiscard]] cv::Rect window(cv::Size size) const;
  void cut_face(cv::Mat& mask, cv::Point origin) const;
  [[nodiscard]] bool touches_head(const Run& run, double margin) const;
  [[nodiscard]] cv::Point2d shoulder(int side) const {
    return face_.centre + cv::Point2d(side * options_.shoulder_aside, options_.shoulder_below) * unit_;
  }
  [[nodiscard]] bool near(const Candidate& c, cv::Point2d p, double face_widths) const {
    return std::any_of(c.runs.begin(), c.runs.end(),
                       [&](const Run& run) { return distance_to(run, p) <= face_widths * unit_; });
  }
  [[nodiscard]] bool at_one_shoulder(const Candidate& c) const {
    return near(c, shoulder(-1), 0.6) != near(c, shoulder(1), 0.6);
  }
  [[nodiscard]] double share_reached(const Candidate& c, bool left, bool right) const;
  [[nodiscard]] bool whole(const Candidate& c) const {
    return std::max(share_reached(c, true, false), share_reached(c, false, true)) >= kWhole;
  }
  [[nodiscard]] double share_on_chest(const Candidate& c) const;
  [[nodiscard]] Candidate made(Blob blob, std::vector<Run> runs, double margin) const;
  [[nodiscard]] std::vector<Candidate> without_chest(const Candidate& c, double margin) const;
  [[nodiscard]] static double extent(const Candidate& a, const Candidate& b, const Moments& both);
  [[nodiscard]] bool one_arm(const Candidate& a, const Candidate& b) const;
  void put_together(std::vector<Candidate>& all) const;

  const ArmOptions& options_;
  const TrackedFace& face_;
  double unit_;  // A face width in pixels.
  double typical_;
};

// Far enough that a leg is seen to be one by what lies beyond an arm's reach.
cv::Rect ArmFinder::Search::window(cv::Size size) const {
  const double aside = (options_.shoulder_aside + kSlack * options_.reach) * unit_;
  const double above = (kSlack * options_.reach - options_.shoulder_below) * unit_ + unit_;
  const double below = (options_.shoulder_below + 2 * options_.reach) * unit_;
  const auto [x0, x1] = pixels(face_.centre.x - aside, face_.centre.x + aside, size.width);
  const auto [y0, y1] = pixels(face_.centre.y - above, face_.centre.y + below, size.height);
  return {x0, y0, x1 - x0, y1 - y0};
}

void ArmFinder::Search::cut_face(cv::Mat& mask, cv::Point origin) const {
  for (int y = 0; y < mask.rows; ++y) {
    const double height = (y + origin.y - face_.centre.y) / unit_;
    const double half = std::max(head_half_width(height), neck_half_width(height)) * unit_;
    if (half < 0) continue;
    const double middle = face_.centre.x - origin.x;
    const auto [from, to] = pixels(middle - half, middle + half, mask.cols);
    if (from < to) mask(cv::Rect(from, y, to - from, 1)).setTo(0);
  }
}

bool ArmFinder::Search::touches_head(const Run& run, double margin) const {
  const double y = std::max(0.0, std::abs(run.y - face_.centre.y + kHeadAbove * unit_) - margin) / unit_;
  const double half = head_half_width(y - kHeadAbove);
  if (half < 0) return false;
  return run.from - face_.centre.x <= half * unit_ + margin && run.to - 1 - face_.centre.x >= -half * unit_ - margin;
}

double ArmFinder::Search::share_reached(const Candidate& c, bool left, bool right) const {
  const double reach = kSlack * options_.reach * unit_;
  double reached = 0;
  for (const auto& run : c.runs) {
    // The stretches of this line that each shoulder reaches; they overlap or one is empty.
    int from = run.to;
    int to = run.from;
    for (const int side : {-1, 1}) {
      if (side < 0 ? !left : !right) continue;
      const auto s = shoulder(side);
      const double half_squared = reach * reach - (run.y - s.y) * (run.y - s.y);
      if (half_squared < 0) continue;
      const double half = std::sqrt(half_squared);
      const auto [a, b] = pixels(s.x - half, s.x + half, run.to);
      if (std::max(a, run.from) >= std::min(b, run.to)) continue;
      from = std::min(from, std::max(a, run.from));
      to = std::max(to, std::min(b, run.to));
    }
    reached += std::max(0, to - from);
  }
  return reached / c.area();
}

double ArmFinder::Search::share_on_chest(const Candidate& c) const {
  double on = 0;
  for (const auto& run : c.runs) {
    const double y = (run.y - face_.centre.y) / unit_;
    if (y < 0 || y > kChestEnd) continue;
    const auto [a, b] =
        pixels(face_.centre.x - kChestHalfWidth * unit_, face_.centre.x + kChestHalfWidth * unit_, run.to);
    on += std::max(0, std::min(b, run.to) - std::max(a, run.from));
  }
  return on / c.area();
}

ArmFinder::Candidate ArmFinder::Search::made(Blob blob, std::vector<Run> runs, double margin) const {
  Candidate c{blob, std::move(runs)};
  c.at_face = std::any_of(c.runs.begin(), c.runs.end(), [&](const Run& run) { return touches_head(run, margin); });
  return c;
}

// The whole arms that are left of a region when the chest is cut out; nothing where that is not what joins them.
std::vector<ArmFinder::Candidate> ArmFinder::Search::without_chest(const Candidate& c, double margin) const {
  const auto box = c.blob.box;
  cv::Mat mask = cv::Mat::zeros(box.size(), CV_8UC1);
  auto runs = c.runs;
  for (auto& run : runs) run = {run.y - box.y, run.from - box.x, run.to - box.x};
  paint(runs, 255, mask);
  const double middle = face_.centre.x - box.x;
  const auto [x0, x1] = pixels(middle - kChestHalfWidth * unit_, middle + kChestHalfWidth * unit_, mask.cols);
  const double face_y = face_.centre.y - box.y;
  const auto [y0, y1] = pixels(face_y, face_y + kChestEnd * unit_, mask.rows);
  if (x0 < x1 && y0 < y1) mask(cv::Rect(x0, y0, x1 - x0, y1 - y0)).setTo(0);

  auto parts = regions_of(mask, int(std::ceil(options_.least_piece * unit_ * unit_)));
  std::vector<Candidate> arms;
  std::size_t large = 0;
  double left = 0;
  for (std::size_t k = 0; k < parts.blobs.size(); ++k) {
    auto& blob = parts.blobs[k];
    blob.moments.centroid += cv::Point2d(box.tl());
    blob.box += box.tl();
    for (auto& run : parts.runs[k]) run = {run.y + box.y, run.from + box.x, run.to + box.x};
    arms.push_back(made(blob, std::move(parts.runs[k]), margin));
    left += arms.back().area();
    if (in_areas(arms.back()) >= kPiece * options_.typical_arm && is_arm(arms.back())) ++large;
  }
  // Crossed forearms lie on the chest themselves: there the cut would take the arms.
  if (large != 2 || left < 0.65 * c.area()) return {};
  return arms;
}

// How far two regions reach along the principal axis of both, px.
double ArmFinder::Search::extent(const Candidate& a, const Candidate& b, const Moments& both) {
  const double angle = std::atan2(2 * both.mu11, both.mu20 - both.mu02) / 2;
  const cv::Point2d axis(std::cos(angle), std::sin(angle));
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const auto* c : {&a, &b}) {
    for (const auto& run : c->runs) {
      for (const int x : {run.from, run.to - 1}) {
        const double along = axis.dot(cv::Point2d(x, run.y));
        low = std::min(low, along);
        high = std::max(high, along);
      }
    }
  }
  return high - low;
}

// Whether two regions are pieces of one arm: one of them short, near each other, in line or around an elbow.
bool ArmFinder::Search::one_arm(const Candidate& a, const Candidate& b) const {
  // Two that the face parts may both be large.
  const bool at_face = a.at_face && b.at_face;
  if (!at_face && std::min(in_areas(a), in_areas(b)) >= kPiece * typical_) return false;
  const auto both = together(a.blob.moments, b.blob.moments);
  if (both.m00 > options_.largest_arm * unit_ * unit_) return false;
  if (std::sqrt(std::max(0.0, least_variance(both))) > kThin * unit_) return false;
  if (extent(a, b, both) > kSlack * options_.reach * unit_) return false;

  double gap = std::numeric_limits<double>::infinity();
  cv::Point2d end_a;
  cv::Point2d end_b;
  for (const auto& one : a.runs) {
    for (const auto& other : b.runs) {
      const double dx = std::max({one.from - (other.to - 1), other.from - (one.to - 1), 0});
      const double d = std::hypot(dx, one.y - other.y);
      if (d >= gap) continue;
      gap = d;
      end_a = {double(one.from > other.to - 1 ? one.from : one.to - 1), double(one.y)};
      end_b = {double(one.from > other.to - 1 ? other.to - 1 : other.from), double(other.y)};
    }
  }
  // What the face hides of an arm before it is not missing between the pieces.
  const bool behind_face = at_face && gap <= 2 * (kHeadHalfHeight + 0.1) * unit_;
  if (gap > options_.piece_gap * unit_ && !behind_face) return false;
  // Side by side they are two arms: the gap must lie between the two, not beside them.
  const auto ca = a.blob.moments.centroid;
  const auto cb = b.blob.moments.centroid;
  const auto middle = (end_a + end_b) * 0.5;
  const double apart = distance(ca, cb);
  if (apart == 0) return false;
  const double detour = distance(ca, middle) + distance(middle, cb) - apart;
  return detour <= 0.25 * apart;
}

void ArmFinder::Search::put_together(std::vector<Candidate>& all) const {
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = i + 1; j < all.size(); ++j) {
      if (!one_arm(all[i], all[j])) continue;
      auto& a = all[i];
      const auto& b = all[j];
      a.blob = {together(a.blob.moments, b.blob.moments), a.blob.box | b.blob.box};
      a.runs.insert(a.runs.end(), b.runs.begin(), b.runs.end());
      a.at_face = a.at_face || b.at_face;
      a.pieced = true;
      all.erase(all.begin() + std::ptrdiff_t(j));
      j = i;  // What is longer now may meet another piece.
    }
  }
}

std::vector<ArmFinder::Candidate> ArmFinder::Search::candidates(const cv::Mat& posterior, const cv::Mat& body) const {
  const auto area = window(posterior.size());
  if (area.empty()) return {};
  const int steps = std::clamp(int(std::lround(options_.anneal * unit_)), 0, 32);
  cv::Mat mask = posterior(area) >= std::max(1.0, std::ceil(options_.min_probability * 255));
  if (!body.empty()) mask.setTo(0, body(area) == 0);
  mask = annealed(mask, steps);
  if (!body.empty()) mask.setTo(0, body(area) == 0);
  cut_face(mask, area.tl());

  const double margin = 1.5 + steps;
  auto regions = regions_of(mask, std::max(1, int(std::ceil(options_.least_piece * unit_ * unit_))));
  std::vector<Candidate> all;
  for (std::size_t k = 0; k < regions.blobs.size(); ++k) {
    auto& blob = regions.blobs[k];
    blob.moments.centroid += cv::Point2d(area.tl());
    blob.box += area.tl();
    for (auto& run : regions.runs[k]) run = {run.y + area.y, run.from + area.x, run.to + area.x};
    auto c = made(blob, std::move(regions.runs[k]), margin);
    if (share_reached(c, true, true) < kMostly) continue;
    std::vector<Candidate> parts;
    if (in_areas(c) > kTwoArms * options_.typical_arm || !whole(c)) parts = without_chest(c, margin);
    if (parts.empty()) parts.push_back(std::move(c));
    for (auto& part : parts) {
      // A neckline; but a forearm may lie there.
      if (share_on_chest(part) > 0.9 && in_areas(part) < kPiece * options_.typical_arm) continue;
      all.push_back(std::move(part));
    }
  }
  const auto larger = [](const Candidate& a, const Candidate& b) { return a.area() > b.area(); };
  std::stable_sort(all.begin(), all.end(), larger);
  if (all.size() > kMostCandidates) all.resize(kMostCandidates);
  put_together(all);
  std::stable_sort(all.begin(), all.end(), larger);
  return all;
}

ArmFinder::ArmFinder(const ArmOptions& options) : options_(options), typical_(options.typical_arm) {
  options_.validate();
}

// Which of the candidates are the arms, with what is remembered of the frames before.
class ArmFinder::Choice {
 public:
  Choice(const Search& search, const std::vector<Candidate>& all, const std::vector<cv::Point2d>& before,
         bool joined_before)
      : search_(search), all_(all), before_(before), joined_before_(joined_before) {
    decide();
    const auto x = [](const Candidate* c) { return c->blob.moments.centroid.x; };
    if (found == ArmCase::kTwoArms && x(arms[1]) < x(arms[0])) std::swap(arms[0], arms[1]);
  }

  ArmCase found = ArmCase::kNoArm;
  std::array<const Candidate*, 2> arms{};  // As many as were found, the left one first; one where they are joined.

 private:
  void decide();
  void take_pair();
  void take_one();
  [[nodiscard]] const Candidate* one_of_two() const;
  [[nodiscard]] bool where_two_were(const Candidate& c) const {
    return before_.size() == 2 && !joined_before_ && search_.in_areas(c) > kStillTwo * search_.typical() &&
           search_.covers(c, before_[0]) && search_.covers(c, before_[1]);
  }
  [[nodiscard]] double nearness(const Candidate& c, cv::Point2d place) const {
    const double d = distance(search_.place(c), place) / 0.75;
    return std::exp(-d * d);
  }

  const Search& search_;
  const std::vector<Candidate>& all_;
  const std::vector<cv::Point2d>& before_;
  bool joined_before_;
};

// The best pair: each as large as an arm, near where the arms were.
void ArmFinder::Choice::take_pair() {
  double best = 0;
  for (std::size_t i = 0; i < all_.size(); ++i) {
    if (!search_.is_arm(all_[i])) continue;
    for (std::size_t j = i + 1; j < all_.size(); ++j) {
      if (!search_.is_arm(all_[j])) continue;
      double score = search_.size(all_[i]) + search_.size(all_[j]);
      if (before_.size() == 2) {
        score += std::max(nearness(all_[i], before_[0]) + nearness(all_[j], before_[1]),
                          nearness(all_[i], before_[1]) + nearness(all_[j], before_[0])) /
                 2;
      }
      if (score > best) {
        best = score;
        arms = {&all_[i], &all_[j]};
        found = ArmCase::kTwoArms;
      }
    }
  }
}

// The best that is an arm by itself.
void ArmFinder::Choice::take_one() {
  double best = 0;
  for (const auto& c : all_) {
    if (!search_.is_arm(c)) continue;
    double score = search_.size(c);
    for (const auto& place : before_) score += nearness(c, place) / 2;
    if (score > best) {
      best = score;
      arms = {&c, nullptr};
      found = ArmCase::kOneArm;
    }
  }
}

// The largest that is as large as two, or reaches as far.
const ArmFinder::Candidate* ArmFinder::Choice::one_of_two() const {
  for (const auto& c : all_) {
    const bool as_before = joined_before_ && !before_.empty() && search_.covers(c, before_[0]);
    if (search_.holds_two(c, as_before ? kStillTwo : kTwoArms)) return &c;
  }
  return nullptr;
}

void ArmFinder::Choice::decide() {
  take_pair();
  if (const auto* both = one_of_two()) {
    // Two arms stay two where this is none of them but could be, or where the other is worth an arm beside it.
    const bool is_first = both == arms[0];
    const bool two = found == ArmCase::kTwoArms && (is_first ? search_.size(*arms[1]) >= 0.35 : search_.is_arm(*both));
    if (two) return;
    arms = {both, nullptr};
    found = ArmCase::kJoined;
    return;
  }
  if (found == ArmCase::kTwoArms) return;
  take_one();
  // Neither went far, so it is both.
  if (found == ArmCase::kOneArm && where_two_were(*arms[0])) found = ArmCase::kJoined;
}

Arms ArmFinder::find(const cv::Mat& posterior, const cv::Mat& body, const std::optional<TrackedFace>& face,
                     double time_s) {
  assert(posterior.type() == CV_8UC1 && (body.empty() || (body.type() == CV_8UC1 && body.size() == posterior.size())));
  Arms arms;
  const double step_s = last_s_ ? std::clamp(time_s - *last_s_, 0.0, kMostStep_s) : 0.0;
  last_s_ = time_s;
  if (!face) return arms;
  assert(face->width > 0);
  if (time_s - before_s_ > options_.memory_s) {
    before_.clear();
    joined_before_ = false;
  }

  const Search search(options_, *face, typical_);
  const auto all = search.candidates(posterior, body);
  const Choice choice(search, all, before_, joined_before_);
  arms.found = choice.found;
  if (choice.found == ArmCase::kNoArm) return arms;

  before_.clear();
  for (std::size_t k = 0; k < 2; ++k) {
    const auto* arm = choice.arms[k];
    if (arm == nullptr) continue;
    arms.blob[k] = arm->blob;
    arms.at_face = arms.at_face || arm->at_face;
    arms.pieced = arms.pieced || arm->pieced;
    before_.push_back(search.place(*arm));
  }
  joined_before_ = arms.found == ArmCase::kJoined;
  before_s_ = time_s;
  if (arms.found == ArmCase::kTwoArms && !arms.at_face) {
    const double larger = std::max(search.in_areas(*choice.arms[0]), search.in_areas(*choice.arms[1]));
    typical_ += (1 - std::exp(-step_s / kLearn_s)) * (larger - typical_);
  }
  return arms;
}

}  // namespace choreo::vision
