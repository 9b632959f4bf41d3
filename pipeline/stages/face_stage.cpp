// SPDX-License-Identifier: Apache-2.0
#include "pipeline/stages/face_stage.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/error.hpp"
#include "pipeline/working_size.hpp"

namespace choreo::pipeline {
namespace {

// The mask's pixels in the picture that is searched, with some room for a head that the mask lacks.
cv::Rect body_box(const cv::Mat& mask, cv::Size size) {
  const auto box = cv::boundingRect(mask);
  if (box.empty()) return {};
  const double sx = double(size.width) / mask.cols;
  const double sy = double(size.height) / mask.rows;
  const double room = 0.08 * size.height;
  const cv::Point from(static_cast<int>(box.x * sx - room), static_cast<int>(box.y * sy - room));
  const cv::Point to(static_cast<int>(box.br().x * sx + room), static_cast<int>(box.br().y * sy + room));
  return cv::Rect(from, to) & cv::Rect({0, 0}, size);
}

}  // namespace

void FaceStageOptions::validate() const {
  search.validate();
  track.validate();
  if (delay_frames < 1 || delay_frames > 60) {
    throw usage_error(fmt::format("delay_frames is {}", delay_frames), {}, "it is from 1 to 60");
  }
  if (rows < 60 || rows > 4320) throw usage_error(fmt::format("rows is {}", rows), {}, "it is from 60 to 4320");
}

FaceStage::FaceStage(std::unique_ptr<vision::FaceDetector> detector, FaceStageOptions options)
    : options_(std::move(options)),
      detector_(std::move(detector)),
      search_(options_.search),
      tracker_(options_.track),
      beside_("face-search", options_.waits, SearchBeside::WhenLate::kVoid) {
  assert(detector_);
  options_.validate();
}

// What takes effect at this frame; null: nothing.
std::shared_ptr<const FaceStage::Search> FaceStage::due(const Observation& observation) {
  const auto due = beside_.begin_frame(frames_++, observation.frame->late_face);
  if (due == SearchBeside::Due::kNothing) return nullptr;
  auto search = std::move(searches_.front());
  searches_.pop_front();
  if (due == SearchBeside::Due::kDone) return search;
  if (options_.on_late) options_.on_late(observation.frame->sequence);
  return nullptr;
}

void FaceStage::ask(const Observation& observation, cv::Size size, const vision::FaceQuery& query) {
  auto search = std::make_shared<Search>();
  search->frame = observation.frame;
  search->sighting.query = query;
  search->sighting.time_s = to_seconds(observation.time);
  // While the wall is learned anew there is a mask without a meaning.
  if (!observation.mask.learning) search->sighting.body = observation.mask.mask;
  searches_.push_back(search);
  const auto work = [this, search, size] {
    const auto& q = search->sighting.query;
    auto& faces = search->sighting.faces;
    try {
      const auto grey = grey_part(search->frame->bgr, size, q.where);
      faces = detector_->detect(grey, {{0, 0}, grey.size()}, q.least_px, q.most_px, q.look);
    } catch (const cv::Exception& error) {
      throw failure(fmt::format("searching for faces failed: {}", error.err));
    }
    for (auto& face : faces) face.box += cv::Point2d(q.where.tl());
  };
  beside_.ask(work, frames_ - 1 + options_.delay_frames);
}

// Takes the face from where it was expected to where its picture is found again.
void FaceStage::follow(vision::TrackedFace& face, cv::Size size, const Search* search, const Observation& observation) {
  if (search != nullptr && to_seconds(observation.time) - search->sighting.time_s == face.unseen_s) {
    const auto apart = [&](const vision::Face& other) {
      return cv::norm((other.box.tl() + other.box.br()) / 2 - face.centre) + std::abs(other.box.width - face.width);
    };
    const auto& faces = search->sighting.faces;
    const auto seen =
        std::min_element(faces.begin(), faces.end(), [&](const auto& a, const auto& b) { return apart(a) < apart(b); });
    if (seen != faces.end()) {
      const auto centre = (seen->box.tl() + seen->box.br()) / 2;
      pattern_.emplace(search->frame->bgr, size, centre, seen->box.width);
    }
  }
  if (pattern_) face.centre = pattern_->find(observation.frame->bgr, {face.centre, last_}).value_or(face.centre);
  last_ = face.centre;
}

void FaceStage::process(Observation& observation) {
  const auto& bgr = observation.frame->bgr;
  const auto search = due(observation);
  if (bgr.empty()) return;
  const auto size = working_size(bgr.size(), options_.rows);
  auto report = tracker_.update(to_seconds(observation.time), size, search ? &search->sighting : nullptr);
  observation.faces = report.in_sight;
  observation.face = followed_.update(observation);
  if (followed_.knows()) {
    if (observation.face) observation.faces = std::max(report.in_sight, 1);
    pattern_.reset();
    return;
  }
  auto candidates = tracker_.candidates();
  const auto chosen = report.face && !candidates.empty() ? candidates.front().id : 0;
  if (std::exchange(chosen_, chosen) != chosen) pattern_.reset();  // Another's.
  if (report.face) {
    if (!pattern_) last_ = report.face->centre;
    follow(*report.face, size, search.get(), observation);
    if (!candidates.empty() && candidates.front().chosen) candidates.front().centre = report.face->centre;
    const auto& picture = observation.picture.empty() ? bgr : observation.picture;
    const double scale = double(picture.rows) / size.height;
    report.face->centre = {report.face->centre.x * picture.cols / size.width, report.face->centre.y * scale};
    report.face->width *= scale;
    observation.face = report.face;
  } else {
    pattern_.reset();
  }
  const auto& mask = observation.mask;
  const auto body = mask.body && !mask.learning ? body_box(mask.mask, size) : cv::Rect();
  if (const auto query = search_.next(size, candidates, body); query && !query->where.empty()) {
    ask(observation, size, *query);
  }
}

}  // namespace choreo::pipeline
