// SPDX-License-Identifier: Apache-2.0
#include "pipeline/background.hpp"

#include <algorithm>
#include <deque>
#include <exception>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "core/error.hpp"
#include "pipeline/even_sampler.hpp"
#include "pipeline/working_size.hpp"
#include "vision/camera_motion.hpp"
#include "vision/quiet_stretches.hpp"

namespace choreo::pipeline {
namespace {

constexpr Nanoseconds kDepthIsLate = std::chrono::seconds(1);  // A device may pair its first frames late.
constexpr Nanoseconds kFirstOfUnrepeatable = std::chrono::seconds(1);

// Gives frames again that were read already, then the rest.
class ResumedSource final : public devices::Source {
 public:
  ResumedSource(std::deque<devices::FramePtr> read, std::unique_ptr<devices::Source> rest)
      : read_(std::move(read)), rest_(std::move(rest)) {}

  [[nodiscard]] const devices::SourceInfo& info() const override { return rest_->info(); }
  devices::FramePtr read(std::stop_token stop) override {
    if (read_.empty()) return rest_->read(std::move(stop));
    auto frame = std::move(read_.front());
    read_.pop_front();
    return frame;
  }
  [[nodiscard]] std::vector<std::string> warnings() const override { return rest_->warnings(); }

 private:
  std::deque<devices::FramePtr> read_;
  std::unique_ptr<devices::Source> rest_;
};

// Goes on reading while somebody computes: a device does not wait, and a recording of it is to have no hole.
class ReadingOn {
 public:
  /// @param frames  gets what is read, until this is destroyed.
  ReadingOn(devices::Source& source, std::deque<devices::FramePtr>& frames)
      : thread_([&source, &frames](const std::stop_token& stop) {
          constexpr std::size_t kMostBytes = std::size_t{512} << 20U;
          try {
            for (std::size_t bytes = 0; bytes < kMostBytes;) {
              auto frame = source.read(stop);
              if (!frame) return;
              bytes += frame->bgr.total() * frame->bgr.elemSize();
              frames.push_back(std::move(frame));
            }
          } catch (const std::exception&) {
            // Whoever reads next meets it again, or the end.
          }
        }) {}

 private:
  std::jthread thread_;
};

[[noreturn]] void refuse_empty(const devices::Source& source) {
  throw usage_error(fmt::format("\"{}\" has no frames", source.info().name));
}

[[noreturn]] void refuse_without_depth(const devices::Source& source) {
  throw usage_error(fmt::format("\"{}\" has no depth", source.info().name), "segmentation",
                    "depth comes from a Kinect (freenect://), OpenNI2 (openni2://), recordings of them and "
                    "synthetic://SCRIPT?depth=1; of other sources take segmentation = \"auto\" or \"colour\"");
}

struct Samples {
  std::vector<cv::Mat> pictures;
  std::vector<double> times_s;                 // As many.
  std::vector<vision::PersonEvidence> people;  // As many, or none where nobody looked.
};

// Brings pictures of a camera that shakes to where it was in the middle one, or for the plate, and what was seen of
// people with them; those in which too little of the room is found again are left out.
vision::CameraKind steady(Samples& samples, const cv::Mat& plate) {
  auto& [pictures, times_s, people] = samples;
  constexpr std::size_t kLeast = 6, kTried = 12;
  if (pictures.size() < kLeast) return vision::CameraKind::kStill;
  const auto middle = pictures.size() / 2;
  cv::Mat reference = plate, covered;
  if (plate.empty()) {
    reference = pictures[middle];
    if (!people.empty() && !people[middle].likely.empty()) covered = vision::possible(people[middle], reference.size());
  }
  const vision::CameraMotion camera(reference, covered);
  if (!camera.can_tell()) return vision::CameraKind::kStill;
  const auto shifts_of = [&](std::span<const cv::Mat> some) {
    std::vector<std::optional<vision::CameraShift>> shifts(some.size());
    tbb::parallel_for(std::size_t{0}, some.size(), [&](std::size_t k) { shifts[k] = camera.of(some[k]); });
    return shifts;
  };
  std::vector<cv::Mat> some;
  const auto count = std::min(kTried, pictures.size());
  for (std::size_t k = 0; k < count; ++k) some.push_back(pictures[k * pictures.size() / count]);
  const auto tried = shifts_of(some);
  const auto kind = vision::kind_of(tried, vision::explains(tried, some, reference));
  if (kind != vision::CameraKind::kShakes) return kind;
  const auto shifts = shifts_of(pictures);
  std::size_t kept = 0;
  for (std::size_t k = 0; k < pictures.size(); ++k) {
    if (!shifts[k]) continue;
    pictures[kept] = vision::brought_back(pictures[k], *shifts[k], reference);
    times_s[kept] = times_s[k];
    if (!people.empty()) people[kept] = vision::brought_back(people[k], *shifts[k]);
    ++kept;
  }
  pictures.resize(kept);
  times_s.resize(kept);
  if (!people.empty()) people.resize(kept);
  return kind;
}

}  // namespace

BackgroundSpec parse_background(std::string_view text) {
  BackgroundSpec spec;
  if (text == "auto") return spec;
  if (text.starts_with("first:")) {
    spec.kind = BackgroundSpec::Kind::kFirst;
    spec.first = parse_duration(text.substr(6));
    if (spec.first <= Nanoseconds{0}) {
      throw usage_error(fmt::format("background \"{}\" is the median of no time at all", text), {},
                        "write first:1s for the first second");
    }
    return spec;
  }
  if (text.empty()) {
    throw usage_error("the background is empty", {},
                      "write auto, first:1s, or the path of a picture of the empty room");
  }
  spec.kind = BackgroundSpec::Kind::kPlate;
  spec.plate = std::string(text);
  return spec;
}

std::optional<LearnedBackground> learn_background(std::unique_ptr<devices::Source> source, const BackgroundSpec& spec,
                                                  const cv::Mat& plate, int working_rows,
                                                  const std::function<std::unique_ptr<devices::Source>()>& reopen,
                                                  const std::function<void(double)>& progress,
                                                  const std::stop_token& stop, vision::Segmentation segmentation,
                                                  const vision::DepthMargin& margin, const PeopleInPictures& people) {
  LearnedBackground learned;
  const auto frame_size = source->info().size;
  const auto size = working_size(frame_size, working_rows);
  const bool repeatable = source->info().repeatable;
  const bool given = spec.kind == BackgroundSpec::Kind::kPlate;
  const bool with_colour = segmentation != vision::Segmentation::kDepth;
  const bool with_depth = segmentation == vision::Segmentation::kDepth || segmentation == vision::Segmentation::kBoth;
  const bool whole =
      (spec.kind == BackgroundSpec::Kind::kAuto || (given && with_depth)) && repeatable && source->info().foreseeable;
  const auto least_time = spec.kind == BackgroundSpec::Kind::kFirst ? spec.first : kFirstOfUnrepeatable;

  if (given && plate.size() != frame_size) {
    throw usage_error(fmt::format("the plate \"{}\" is {} x {} pixels, the frames of \"{}\" are {} x {}", spec.plate,
                                  plate.cols, plate.rows, source->info().name, frame_size.width, frame_size.height),
                      {}, "take the plate with the same camera and settings as the recording");
  }
  EvenSampler<cv::Mat> sampler(most_pictures(size));
  EvenSampler<double> times(most_pictures(size));  // Of the same.
  EvenSampler<cv::Mat> depths(most_pictures(size));
  vision::QuietStretches quiet;
  std::deque<devices::FramePtr> kept;
  std::optional<Nanoseconds> origin;
  // A given plate still needs some pictures: the sensor's noise is in them, not in the plate.
  constexpr Nanoseconds kNoiseTime = std::chrono::seconds(1);
  // A recording that breaks off teaches with what it has: whether a chosen frame is lost shows when those are read.
  const auto next = [&](bool with_picture = true) {
    try {
      return with_picture ? source->read(stop) : source->skim(stop);
    } catch (const Error& error) {
      if (!repeatable || !origin || error.fault() != Fault::kFailure) throw;
      return devices::FramePtr();
    }
  };
  // Where people are looked for first, what is still for a while is asked for only where nobody is seen.
  const bool people_first =
      segmentation == vision::Segmentation::kPerson || segmentation == vision::Segmentation::kAuto;
  const bool asks_twice = segmentation == vision::Segmentation::kAuto && whole;
  const bool asks_what_is_still = !given && segmentation != vision::Segmentation::kPerson && !asks_twice;
  const bool every_picture = given || asks_what_is_still || with_depth || !repeatable;
  const auto tell = [&](Nanoseconds time) {
    if (!progress) return;
    const auto duration = whole ? source->info().duration.value_or(Nanoseconds{0}) : least_time;
    progress(duration > Nanoseconds{0} ? std::min(1.0, to_seconds(time) / to_seconds(duration)) : -1.0);
  };
  while (auto frame = next(every_picture || sampler.wants())) {
    if (!origin) origin = frame->device_time;
    const auto time = frame->device_time - *origin;
    if (!repeatable) kept.push_back(frame);
    if (!whole && time >= (given ? kNoiseTime : least_time)) break;
    ++learned.frames_read;
    if (with_depth && !frame->depth.empty()) depths.offer([&] { return depth_at_working_size(frame->depth, size); });
    if (with_depth && depths.kept().empty() && time >= kDepthIsLate) refuse_without_depth(*source);
    if (with_colour && (!given || time < kNoiseTime)) {
      cv::Mat picture;
      const auto seen = [&] { return picture.empty() ? picture = at_working_size(frame->bgr, size) : picture; };
      sampler.offer(seen);
      times.add(to_seconds(time));
      if (asks_what_is_still) quiet.add(seen(), to_seconds(time));
    }
    tell(time);
  }
  if (stop.stop_requested()) return std::nullopt;
  std::optional<ReadingOn> reading_on;
  if (source->info().live) reading_on.emplace(*source, kept);
  if (learned.frames_read == 0) refuse_empty(*source);
  const cv::Mat small_plate = given && with_colour ? at_working_size(plate, size) : cv::Mat();
  if (with_depth) {
    if (depths.kept().empty()) refuse_without_depth(*source);
    learned.depth = vision::learn_depth_background(depths.kept(), margin);
    learned.pictures = depths.kept().size();
  }
  Samples samples{sampler.kept(), times.kept(), {}};
  if (people_first) {
    const std::size_t most = whole ? 60 : 20;  // What no sixtieth of a clip shows is as good as unseen.
    const auto count = std::min(samples.pictures.size(), most);
    Samples some;
    for (std::size_t k = 0; k < count; ++k) {
      some.pictures.push_back(samples.pictures[k * samples.pictures.size() / count]);
      some.times_s.push_back(samples.times_s[k * samples.pictures.size() / count]);
    }
    some.people = people(some.pictures);
    if (stop.stop_requested()) return std::nullopt;
    const auto seen =
        std::size_t(std::ranges::count_if(some.people, [](const auto& person) { return !person.likely.empty(); }));
    constexpr std::size_t kByMistake = 20;  // One look of so many.
    learned.somebody = seen > count / kByMistake;
    if (!given && (learned.somebody || segmentation == vision::Segmentation::kPerson)) samples = std::move(some);
  }
  auto camera = vision::CameraKind::kStill;
  if (with_colour && !with_depth) camera = steady(samples, small_plate);
  const auto& pictures = samples.pictures;
  if (!with_colour) {
    // Nothing looks at colour.
  } else if (given) {
    learned.estimate = vision::judge_plate(small_plate, pictures);
    learned.estimate.unseen = 0;  // Whoever gives a plate has seen the room.
  } else if (!samples.people.empty()) {
    learned.estimate = vision::background_behind_people(pictures, samples.people);
    learned.pictures = pictures.size();
  } else {
    if (camera == vision::CameraKind::kShakes) {
      quiet = {};
      for (std::size_t k = 0; k < pictures.size(); ++k) quiet.add(pictures[k], samples.times_s[k]);
    }
    if (asks_twice && camera != vision::CameraKind::kShakes) {
      source.reset();
      source = reopen();
      origin.reset();
      while (const auto frame = next()) {
        if (!origin) origin = frame->device_time;
        const auto time = frame->device_time - *origin;
        quiet.add(at_working_size(frame->bgr, size), to_seconds(time));
        tell(time);
      }
      if (stop.stop_requested()) return std::nullopt;
    }
    const auto still = quiet.finish();
    learned.estimate =
        whole ? vision::estimate_background(pictures, still) : vision::estimate_beginning(pictures, still);
    learned.pictures = pictures.size();
  }
  learned.estimate.camera = camera;
  if (camera == vision::CameraKind::kMayMove && !samples.people.empty()) {
    // Pictures from several places tell of no place what is there, nor how much noise is in it.
    learned.estimate.never_seen = cv::Mat(size, CV_8UC1, cv::Scalar(255));
    learned.estimate.noise = 0;
  }
  reading_on.reset();
  if (stop.stop_requested()) return std::nullopt;
  if (repeatable) {
    source.reset();
    learned.source = reopen();
  } else {
    learned.source = std::make_unique<ResumedSource>(std::move(kept), std::move(source));
  }
  return learned;
}

}  // namespace choreo::pipeline
