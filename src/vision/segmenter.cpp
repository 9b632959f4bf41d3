// SPDX-License-Identifier: Apache-2.0
#include "vision/segmenter.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "vision/difference.hpp"

namespace choreo::vision {
namespace {

constexpr double kAbsorbed = 3;       // Seconds that something stands still which no look calls a person.
constexpr double kSeenFor = 1 / 3.0;  // Seconds; a single look may be mistaken.
constexpr double kLostFor = 1;        // Seconds until a camera that shakes is taken for moved.
constexpr double kAgreement = 0.9;
constexpr int kLooksAround = 4;         // times the edge's width
constexpr int kWatchedRows = 240;       // Enough to tell that a camera moves.
constexpr int kRowsPerEdgePixel = 160;  // a depth edge wanders by about as many pixels of 480 rows

cv::Mat square(int reach) { return cv::getStructuringElement(cv::MORPH_RECT, {2 * reach + 1, 2 * reach + 1}); }

cv::Mat at_most_rows(const cv::Mat& picture, int rows) {
  if (picture.rows <= rows) return picture;
  cv::Mat out;
  cv::resize(picture, out, {std::max(1, picture.cols * rows / picture.rows), rows}, 0, 0, cv::INTER_AREA);
  return out;
}

// How many pixels are set within `reach`, everywhere.
cv::Mat count_around(const cv::Mat& mask, int reach) {
  cv::Mat sum;
  const int side = 2 * reach + 1;
  cv::boxFilter(mask & 1, sum, CV_32F, {side, side}, {-1, -1}, false, cv::BORDER_CONSTANT);
  return sum;
}

// Where `colour` has at least kAgreement of what is set in `sure` nearby, and something is.
cv::Mat agrees(const cv::Mat& colour, const cv::Mat& sure, int reach) {
  const cv::Mat all = count_around(sure, reach);
  const cv::Mat both = count_around(sure & colour, reach);
  return (all >= 1) & (both >= kAgreement * all);
}

}  // namespace

Segmentation segmentation_named(std::string_view name) {
  if (name == "colour") return Segmentation::kColour;
  if (name == "depth") return Segmentation::kDepth;
  if (name == "both") return Segmentation::kBoth;
  if (name == "person") return Segmentation::kPerson;
  assert(name == "auto");
  return Segmentation::kAuto;
}

cv::Mat combined(const cv::Mat& by_colour, const cv::Mat& by_depth, const cv::Mat& known, int edge_px) {
  assert(edge_px > 0);
  cv::Mat grown, shrunk;
  cv::dilate(by_depth, grown, square(edge_px));
  cv::erode(by_depth, shrunk, square(edge_px));
  const cv::Mat not_colour = ~by_colour;
  const cv::Mat outside = ~grown & known;
  const int reach = kLooksAround * edge_px;
  const cv::Mat trusted = agrees(by_colour, shrunk, reach) & agrees(not_colour, outside, reach);
  const cv::Mat by_colour_here = (grown & ~shrunk & trusted) | (~known & ~by_depth);
  cv::Mat out = by_depth.clone();
  by_colour.copyTo(out, by_colour_here);
  return out;
}

Segmenter::Segmenter(BodyMasker colour) : colour_(std::move(colour)) {}

Segmenter::Segmenter(PersonMasker person) : person_(std::move(person)) {}

Segmenter::Segmenter(const BackgroundEstimate& background, MaskOptions options, bool somebody)
    : options_(std::move(options)), as_it_turns_out_(true), noise_(background.noise) {
  if (somebody) {
    person_.emplace(background, options_);
  } else {
    auto whatever = options_;
    whatever.absorb_s = kAbsorbed;
    colour_.emplace(background, std::move(whatever));
  }
}

std::optional<double> Segmenter::threshold() const {
  if (person_) return person_->threshold();
  return colour_ ? std::optional(colour_->threshold()) : std::nullopt;
}

// What was learned of the background by then holds.
void Segmenter::meet(const PersonEvidence& person, const cv::Mat& differs, double time_s) {
  constexpr double kDiffers = 0.2;  // Of a person; of the foot of a table that is mistaken for one nothing does.
  const cv::Mat likely = person.likely.empty() ? cv::Mat() : cv::Mat(person.likely > 127);
  if (likely.empty() || cv::countNonZero(likely & differs) < kDiffers * cv::countNonZero(likely)) {
    there_since_s_.reset();
    return;
  }
  if (!there_since_s_) there_since_s_ = time_s;
  if (time_s - *there_since_s_ < kSeenFor) return;
  BackgroundEstimate so_far;
  so_far.plate = colour_->background();
  so_far.noise = noise_;
  person_.emplace(so_far, options_);
  colour_.reset();
}

Segmenter::Segmenter(std::optional<BodyMasker> colour, DepthMasker depth, MaskOptions options)
    : colour_(std::move(colour)), depth_(std::move(depth)), options_(std::move(options)) {}

void Segmenter::follow_camera(const BackgroundEstimate& background) {
  camera_.reset();
  const auto& plate = background.plate;
  if (background.camera == CameraKind::kShakes) {
    // Corners of what stood before a wall that was never seen are no corners of the room.
    camera_ = {CameraKind::kShakes, plate, CameraMotion(plate, background.never_seen), {}, {}};
  } else if (background.camera == CameraKind::kMayMove) {
    watch(plate, {});
  }
}

// From now on whether the camera moves is seen from picture to picture.
void Segmenter::watch(const cv::Mat& picture, const PersonEvidence& person) {
  const auto small = at_most_rows(picture, kWatchedRows);
  cv::Mat covered = possible(person, picture.size());
  if (!person.about_others.empty()) covered |= person.about_others;
  cv::resize(covered, covered, small.size(), 0, 0, cv::INTER_NEAREST);
  camera_ = {CameraKind::kMayMove, small, CameraMotion(small, covered), {}, {}};
}

MaskResult Segmenter::process(const cv::Mat& picture, const cv::Mat& depth_mm, double time_s,
                              const PersonEvidence& person) {
  const bool of_person = person_.has_value();
  auto result = !camera_                               ? of_steady(picture, depth_mm, time_s, person)
                : camera_->kind == CameraKind::kShakes ? of_shaken(picture, depth_mm, time_s, person)
                                                       : of_watched(picture, depth_mm, time_s, person);
  result.of_person = of_person;
  return result;
}

// Where the camera stands for a while, what is behind the person is learned.
MaskResult Segmenter::of_watched(const cv::Mat& picture, const cv::Mat& depth_mm, double time_s,
                                 const PersonEvidence& person) {
  const auto small = at_most_rows(picture, kWatchedRows);
  const std::array shift = {camera_->motion.of(small)};
  // Once may be somebody who steps before the corners; a pan goes on.
  const bool lost = !shift[0] && camera_->motion.can_tell();
  const bool moves = (lost && camera_->lost_since_s) ||
                     (shift[0] && shift[0] != kNoShift && explains(shift, {&small, 1}, camera_->plate));
  // Since the last move, so that a slow one adds up.
  if (moves || !shift[0]) watch(picture, person);
  camera_->lost_since_s = lost ? std::optional(time_s) : std::nullopt;
  if (moves && person_) person_->forget(picture);
  auto result = of_steady(picture, depth_mm, time_s, person);
  if (moves && !person_) {
    result.mask = cv::Mat::zeros(picture.size(), CV_8UC1);
    result.area = result.inferred = 0;
    result.body = result.cut = false;
  }
  result.camera_moved = moves;
  return result;
}

// The picture is brought to where the camera was, and its mask back.
MaskResult Segmenter::of_shaken(const cv::Mat& picture, const cv::Mat& depth_mm, double time_s,
                                const PersonEvidence& person) {
  auto& camera = *camera_;
  const auto last = camera.shifts.empty() ? kNoShift : camera.shifts.back().second;
  auto shift = camera.motion.of(picture, last);
  if (!shift && last != kNoShift) shift = camera.motion.of(picture);
  if (!shift) {
    if (!camera.lost_since_s) camera.lost_since_s = time_s;
    if (time_s - *camera.lost_since_s >= std::max(kLostFor, options_.relearn_s)) {
      // It stands elsewhere for good.
      watch(picture, person);
      if (person_) person_->forget(picture);
      return of_steady(picture, depth_mm, time_s, person);
    }
    MaskResult result;
    if (person_) {
      result = person_->silhouette(person);
    } else {
      result.mask = cv::Mat::zeros(picture.size(), CV_8UC1);
    }
    result.camera_moved = true;
    return result;
  }
  camera.lost_since_s.reset();
  camera.shifts.emplace_back(time_s, *shift);
  constexpr std::size_t kKept = 120;  // A look is at most so many frames old.
  if (camera.shifts.size() > kKept) camera.shifts.pop_front();
  // A look is of a frame before, when the camera was elsewhere.
  const double seen_s = person.seen_s.value_or(time_s);
  const auto then =
      std::ranges::min_element(camera.shifts, {}, [&](const auto& one) { return std::abs(one.first - seen_s); });
  auto result =
      of_steady(brought_back(picture, *shift, camera.plate), depth_mm, time_s, brought_back(person, then->second));
  if (*shift == kNoShift || !result.body) return result;
  // Beyond what the plate shows the network alone has a word.
  cv::Mat beyond = cv::Mat::zeros(picture.size(), CV_8UC1);
  if (person_ && !person.likely.empty()) beyond = person_->silhouette(person).mask;
  const int before = result.area;
  const int shown = cv::countNonZero(taken_along(result.mask, *shift, cv::Mat::zeros(picture.size(), CV_8UC1)));
  result.mask = taken_along(result.mask, *shift, beyond);
  result.area = cv::countNonZero(result.mask);
  result.inferred = std::min(result.area, result.inferred + result.area - shown);
  constexpr int kLeast = 10;  // A tenth of it is more than a remnant at the border.
  result.body = kLeast * result.area > before;
  const auto box = cv::boundingRect(result.mask);
  result.cut = result.body &&
               (result.cut || box.x == 0 || box.y == 0 || box.br().x == picture.cols || box.br().y == picture.rows);
  if (!result.body) result = {.mask = cv::Mat::zeros(picture.size(), CV_8UC1), .sudden = result.sudden};
  return result;
}

MaskResult Segmenter::of_steady(const cv::Mat& picture, const cv::Mat& depth_mm, double time_s,
                                const PersonEvidence& person) {
  if (person_) return person_->process(picture, person, time_s);
  MaskResult by_colour;
  if (colour_) by_colour = colour_->process(picture, time_s);
  if (as_it_turns_out_) meet(person, by_colour.mask, time_s);
  if (!depth_) return by_colour;
  if (depth_mm.empty()) {
    if (!colour_) by_colour.mask = cv::Mat::zeros(picture.size(), CV_8UC1);
    return by_colour;
  }
  const auto by_depth = depth_->process(depth_mm, time_s);
  if (colour_ && by_depth.learning) {
    by_colour.sudden = by_colour.sudden || by_depth.sudden;
    return by_colour;
  }
  if (!colour_) return finished(by_depth.body, by_depth);
  const int edge_px = std::max(1, depth_mm.rows / kRowsPerEdgePixel);
  auto result = finished(combined(by_colour.mask, by_depth.body, by_depth.known, edge_px), by_depth);
  result.sudden = result.sudden || by_colour.sudden;
  return result;
}

MaskResult Segmenter::finished(cv::Mat mask, const DepthMask& depth) const {
  MaskResult result;
  result.sudden = depth.sudden;
  result.learning = depth.learning;
  result.mask = cv::Mat::zeros(mask.size(), CV_8UC1);
  const double pixels = double(mask.total());
  mask =
      without_specks(mask, static_cast<int>(std::ceil(options_.speck_percent / 100.0 * pixels)), options_.largest_only);
  const int area = cv::countNonZero(mask);
  if (area == 0 || area < options_.min_body_percent / 100.0 * pixels) return result;
  result.mask = mask;
  result.area = area;
  if (!depth.inferred.empty()) result.inferred = cv::countNonZero(mask & depth.inferred);
  result.body = true;
  const auto box = cv::boundingRect(mask);
  result.cut = box.x == 0 || box.y == 0 || box.br().x == mask.cols || box.br().y == mask.rows;
  return result;
}

}  // namespace choreo::vision
