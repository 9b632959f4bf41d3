// SPDX-License-Identifier: Apache-2.0
#include "pipeline/stages/face_stage.hpp"

#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "core/error.hpp"
#include "pipeline/working_size.hpp"

namespace choreo::pipeline {
namespace {

constexpr int kNice = 10;  // Of the thread that searches.

// The part `where` of the picture of `size` rows and columns that the frame gives, grey.
cv::Mat grey_part(const cv::Mat& bgr, cv::Size size, const cv::Rect& where) {
  cv::Mat part;
  if (bgr.size() == size) {
    part = bgr(where);
  } else {
    const double sx = double(bgr.cols) / size.width;
    const double sy = double(bgr.rows) / size.height;
    const cv::Point from(static_cast<int>(where.x * sx), static_cast<int>(where.y * sy));
    const cv::Point to(static_cast<int>(std::ceil(where.br().x * sx)), static_cast<int>(std::ceil(where.br().y * sy)));
    cv::resize(bgr(cv::Rect(from, to) & cv::Rect({0, 0}, bgr.size())), part, where.size(), 0, 0, cv::INTER_AREA);
  }
  cv::Mat grey;
  cv::cvtColor(part, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

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

// What is not const belongs to `mutex_`.
struct FaceStage::Job {
  devices::FramePtr frame;
  cv::Size size;  // Of the detection picture.
  std::uint64_t due = 0;
  vision::FaceSighting sighting;  // Without its faces until it is done.
  bool done = false, is_void = false;
  std::exception_ptr problem = nullptr;
};

void FaceStageOptions::validate() const {
  search.validate();
  track.validate();
  if (delay_frames < 1 || delay_frames > 60) {
    throw usage_error(fmt::format("delay_frames is {}", delay_frames), {}, "it is from 1 to 60");
  }
  if (rows < 60 || rows > 4320) throw usage_error(fmt::format("rows is {}", rows), {}, "it is from 60 to 4320");
}

FaceStage::FaceStage(std::unique_ptr<vision::FaceDetector> detector, FaceStageOptions options)
    : options_(std::move(options)), detector_(std::move(detector)), search_(options_.search), tracker_(options_.track) {
  assert(detector_);
  options_.validate();
  thread_ = std::thread([this] { work(); });
}

FaceStage::~FaceStage() { stop(); }

void FaceStage::stop() {
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void FaceStage::work() {
  pthread_setname_np(pthread_self(), "face-search");
  // Frames come first; where that cannot be had, it is as it was.
  (void)setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
  for (;;) {
    std::shared_ptr<Job> job;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return stopping_ || !waiting_.empty(); });
      if (stopping_) return;
      job = std::move(waiting_.front());
      waiting_.pop_front();
    }
    std::vector<vision::Face> faces;
    std::exception_ptr problem;
    try {
      const auto& query = job->sighting.query;
      const auto grey = grey_part(job->frame->bgr, job->size, query.where);
      faces = detector_->detect(grey, {{0, 0}, grey.size()}, query.least_px, query.most_px, query.look);
      for (auto& face : faces) face.box += cv::Point2d(query.where.tl());
    } catch (const cv::Exception& error) {
      problem = std::make_exception_ptr(failure(fmt::format("searching for faces failed: {}", error.err)));
    } catch (...) {
      problem = std::current_exception();
    }
    {
      const std::scoped_lock lock(mutex_);
      job->sighting.faces = std::move(faces);
      job->problem = problem;
      job->done = true;
      if (job->is_void && problem) problem_ = problem;
    }
    changed_.notify_all();
  }
}

// What takes effect at this frame.
std::unique_ptr<vision::FaceSighting> FaceStage::due(const Observation& observation) {
  if (pending_.empty() || pending_.front()->due != frames_) return nullptr;
  const auto job = std::move(pending_.front());
  pending_.pop_front();
  std::unique_lock lock(mutex_);
  const bool again = observation.frame->late_face;
  if (options_.waits && !again) changed_.wait(lock, [&] { return job->done; });
  if (!job->done || again) {
    job->is_void = true;
    std::erase(waiting_, job);  // Where it was not begun: its frame is memory.
    ++late_;
    lock.unlock();
    if (options_.on_late) options_.on_late(observation.frame->sequence);
    return nullptr;
  }
  if (job->problem) std::rethrow_exception(job->problem);
  return std::make_unique<vision::FaceSighting>(std::move(job->sighting));
}

void FaceStage::ask(const Observation& observation, cv::Size size, const vision::FaceQuery& query) {
  auto job = std::make_shared<Job>();
  job->frame = observation.frame;
  job->size = size;
  job->due = frames_ + static_cast<std::uint64_t>(options_.delay_frames);
  job->sighting.query = query;
  job->sighting.time_s = to_seconds(observation.time);
  // While the wall is learned anew there is a mask without a meaning.
  if (!observation.mask.learning) job->sighting.body = observation.mask.mask;
  ++asked_;
  pending_.push_back(job);
  {
    const std::scoped_lock lock(mutex_);
    waiting_.push_back(std::move(job));
  }
  changed_.notify_all();
}

void FaceStage::process(Observation& observation) {
  {
    const std::scoped_lock lock(mutex_);
    if (problem_) std::rethrow_exception(problem_);
  }
  const auto& bgr = observation.frame->bgr;
  const auto sighting = due(observation);
  if (!bgr.empty()) {
    const auto size = working_size(bgr.size(), options_.rows);
    auto report = tracker_.update(to_seconds(observation.time), size, sighting.get());
    observation.faces = report.in_sight;
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
  ++frames_;
}

}  // namespace choreo::pipeline
