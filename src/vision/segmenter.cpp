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
void Segmenter::meet(const PersonEvidence& person, double time_s) {
  if (person.likely.empty()) {
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

void Segmenter::follow_camera(CameraKind kind, const cv::Mat& plate) {
  camera_.reset();
  if (kind == CameraKind::kStill) return;
  const auto reference = kind == CameraKind::kMayMove ? at_most_rows(plate, kWatchedRows) : plate;
  camera_ = {kind, reference, CameraMotion(reference), kNoShift};
}

MaskResult Segmenter::process(const cv::Mat& picture, const cv::Mat& depth_mm, double time_s,
                              const PersonEvidence& person) {
  if (!camera_) return of_steady(picture, depth_mm, time_s, person);
  auto& camera = *camera_;
  if (camera.kind == CameraKind::kMayMove) {
    // Where it stands for a while, what is behind the person is learned.
    const auto small = at_most_rows(picture, kWatchedRows);
    const std::array shift = {camera.motion.of(small)};
    const bool moves = shift[0] && shift[0] != kNoShift && explains(shift, {&small, 1}, camera.plate);
    camera.motion = CameraMotion(small);
    camera.plate = small;
    if (moves && person_) person_->forget(picture);
    auto result = of_steady(picture, depth_mm, time_s, person);
    result.camera_moved = moves && person_;
    return result;
  }
  auto shift = camera.motion.of(picture, camera.last);
  if (!shift && camera.last != kNoShift) shift = camera.motion.of(picture);
  if (!shift) {
    MaskResult result;
    if (person_) {
      result = person_->silhouette(person);
    } else {
      result.mask = cv::Mat::zeros(picture.size(), CV_8UC1);
    }
    result.camera_moved = true;
    return result;
  }
  camera.last = *shift;
  auto result = of_steady(brought_back(picture, *shift, camera.plate), depth_mm, time_s, brought_back(person, *shift));
  if (*shift == kNoShift) return result;
  // Beyond what the plate shows the network alone has a word.
  const bool seen = result.body && person_ && !person.likely.empty();
  const cv::Mat beyond = seen ? person_->silhouette(person).mask : cv::Mat::zeros(picture.size(), CV_8UC1);
  result.mask = taken_along(result.mask, *shift, beyond);
  result.area = cv::countNonZero(result.mask);
  result.body = result.area > 0;
  const auto box = cv::boundingRect(result.mask);
  result.cut = result.body && (box.x == 0 || box.y == 0 || box.br().x == picture.cols || box.br().y == picture.rows);
  return result;
}

MaskResult Segmenter::of_steady(const cv::Mat& picture, const cv::Mat& depth_mm, double time_s,
                                const PersonEvidence& person) {
  if (person_) return person_->process(picture, person, time_s);
  MaskResult by_colour;
  if (colour_) by_colour = colour_->process(picture, time_s);
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
