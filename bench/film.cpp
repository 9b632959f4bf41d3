// SPDX-License-Identifier: Apache-2.0
#include "film.hpp"

#include <string>

namespace choreo::bench {
namespace {

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

std::unique_ptr<devices::Source> borrowed(Film& film) { return std::make_unique<Borrowed>(film); }

}  // namespace choreo::bench
