// SPDX-License-Identifier: Apache-2.0
#include "film.hpp"

#include <string>
#include <utility>

#include "pipeline/pacing.hpp"
#include "pipeline/steady_clock.hpp"
#include "pipeline/working_size.hpp"

namespace choreo::bench {
namespace {

// What a runner may own.
class Borrowed final : public devices::Source {
 public:
  explicit Borrowed(Film& film) : film_(film) {}
  [[nodiscard]] const devices::SourceInfo& info() const override { return film_.info(); }
  devices::FramePtr read(std::stop_token stop) override { return film_.read(stop); }
  [[nodiscard]] std::vector<std::string> warnings() const override { return {}; }

 private:
  Film& film_;
};

}  // namespace

Film::Film(std::string_view script, const devices::synthetic::PerformerSettings& settings, int frames) {
  const devices::synthetic::Performer performer(script, settings);
  const int first = performer.first_frame();
  for (int i = 0; i < frames; ++i) pictures_.push_back(performer.perform(first + i).bgr);
  room_ = performer.room();
  info_.size = settings.size;
  info_.nominal_fps = settings.fps;
}

devices::FramePtr Film::read(std::stop_token /*stop*/) {
  if (next_ == end_) return nullptr;
  auto frame = std::make_shared<devices::Frame>();
  frame->sequence = next_;
  frame->device_time = from_seconds(double(next_) / info_.nominal_fps);
  frame->bgr = pictures_[next_ % pictures_.size()];
  ++next_;
  return frame;
}

vision::BodyMasker masker_for(const Film& film, cv::Size working) {
  return {pipeline::at_working_size(film.room(), working), kFilmNoise, {}};
}

pipeline::RunReport run_film(Film& film, std::vector<std::unique_ptr<pipeline::Stage>>& stages, int threads, Pace pace,
                             std::uint64_t frames, const Clock& clock) {
  film.rewind(frames);
  pipeline::RunnerOptions options;
  options.threads = threads;
  options.queue_capacity = 2;
  std::unique_ptr<devices::Source> source = std::make_unique<Borrowed>(film);
  if (pace == Pace::kCamera) {
    options.at_reader = pipeline::Overflow::kDropOldest;
    source = std::make_unique<pipeline::PacedSource>(std::move(source), clock, pipeline::sleep_until);
  }
  return pipeline::run(*source, {}, stages, options, clock, {});
}

}  // namespace choreo::bench
