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
std::shared_ptr<const vision::FaceSighting> FaceStage::due(const Observation& observation) {
  const auto due = beside_.begin_frame(frames_++, observation.frame->late_face);
  if (due == SearchBeside::Due::kNothing) return nullptr;
  auto sighting = std::move(sightings_.front());
  sightings_.pop_front();
  if (due == SearchBeside::Due::kDone) return sighting;
  if (options_.on_late) options_.on_late(observation.frame->sequence);
  return nullptr;
}

void FaceStage::ask(const Observation& observation, cv::Size size, const vision::FaceQuery& query) {
  auto sighting = std::make_shared<vision::FaceSighting>();
  sighting->query = query;
  sighting->time_s = to_seconds(observation.time);
  // While the wall is learned anew there is a mask without a meaning.
  if (!observation.mask.learning) sighting->body = observation.mask.mask;
  sightings_.push_back(sighting);
  beside_.ask(
      [this, sighting, size, frame = observation.frame] {
        const auto& q = sighting->query;
        try {
          const auto grey = grey_part(frame->bgr, size, q.where);
          sighting->faces = detector_->detect(grey, {{0, 0}, grey.size()}, q.least_px, q.most_px, q.look);
        } catch (const cv::Exception& error) {
          throw failure(fmt::format("searching for faces failed: {}", error.err));
        }
        for (auto& face : sighting->faces) face.box += cv::Point2d(q.where.tl());
      },
      frames_ - 1 + options_.delay_frames);
}

void FaceStage::process(Observation& observation) {
  const auto& bgr = observation.frame->bgr;
  const auto sighting = due(observation);
  if (!bgr.empty()) {
    const auto size = working_size(bgr.size(), options_.rows);
    auto report = tracker_.update(to_seconds(observation.time), size, sighting.get());
    observation.faces = report.in_sight;
    observation.face = followed_.update(observation);
    if (followed_.knows()) {
      if (observation.face) observation.faces = std::max(report.in_sight, 1);
      return;
    }
    const auto& picture = observation.picture.empty() ? bgr : observation.picture;
    if (report.face) {
      const double scale = double(picture.rows) / size.height;
      report.face->centre = {report.face->centre.x * picture.cols / size.width, report.face->centre.y * scale};
      report.face->width *= scale;
      observation.face = report.face;
    }
    const auto& mask = observation.mask;
    const auto body = mask.body && !mask.learning ? body_box(mask.mask, size) : cv::Rect();
    if (const auto query = search_.next(size, tracker_.candidates(), body); query && !query->where.empty()) {
      ask(observation, size, *query);
    }
  }
}

}  // namespace choreo::pipeline
