// SPDX-License-Identifier: Apache-2.0
#include "devices/synthetic/synthetic_source.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/text.hpp"

namespace choreo::devices {
namespace {

using synthetic::Performer;
using synthetic::PerformerSettings;

cv::Size parse_size(const SourceUri& uri, const std::string& text) {
  const auto cross = text.find('x');
  const auto width = parse_integer(text.substr(0, cross));
  const auto height = cross == std::string::npos ? std::nullopt : parse_integer(text.substr(cross + 1));
  if (!width || !height || *width < 0 || *height < 0 || *width > 100000 || *height > 100000) {
    throw usage_error(fmt::format("source \"{}\": size is \"{}\"", uri.text, text), {},
                      "size is WIDTHxHEIGHT in pixels, from 16x16 to 3840x2160 (default 640x480)");
  }
  return {static_cast<int>(*width), static_cast<int>(*height)};
}

synthetic::CameraPan parse_pan(const SourceUri& uri, const std::string& text) {
  std::array<double, 3> values = {0, 0, 1};
  std::size_t count = 0;
  bool good = true;
  for (std::size_t from = 0; good && from <= text.size(); ++count) {
    const auto colon = std::min(text.find(':', from), text.size());
    const auto value = count < values.size() ? parse_number(text.substr(from, colon - from)) : std::nullopt;
    good = value.has_value();
    if (good) values[count] = *value;
    from = colon + 1;
  }
  if (!good || count < 2) {
    throw usage_error(fmt::format("source \"{}\": pan is \"{}\"", uri.text, text), {},
                      "pan is RIGHT:DOWN or RIGHT:DOWN:ZOOM, pixels from -64 to 64 and a factor from 0.9 to 1.1");
  }
  return {values[0], values[1], values[2]};
}

class SyntheticSource final : public Source {
 public:
  SyntheticSource(const SourceUri& uri, const PerformerRequest& request)
      : performer_(request.script, request.settings) {
    info_.name = uri.text;
    info_.size = request.settings.size;
    info_.nominal_fps = request.settings.fps;
    info_.depth = request.settings.depth;
    info_.duration = from_seconds(performer_.frame_count() / request.settings.fps);
  }

  const SourceInfo& info() const override { return info_; }

  FramePtr read(std::stop_token stop) override {
    if (stop.stop_requested() || next_ >= performer_.frame_count()) return nullptr;
    auto performance = performer_.perform(next_);
    auto frame = std::make_shared<Frame>();
    frame->sequence = static_cast<std::uint64_t>(next_++);
    frame->device_time = performance.time;
    frame->bgr = std::move(performance.bgr);
    frame->depth = std::move(performance.depth);
    return frame;
  }

 private:
  Performer performer_;
  SourceInfo info_;
  int next_ = 0;
};

}  // namespace

PerformerRequest performer_request(const SourceUri& uri, SettingReader& settings) {
  PerformerRequest request;
  request.script = synthetic::script_facts(uri.location).name;
  auto& s = request.settings;
  s.size = parse_size(uri, settings.take_text("size", "640x480"));
  s.fps = settings.take_number("fps", s.fps, 1, 240);
  s.seed = static_cast<std::uint64_t>(settings.take_integer("seed", 1, 0, 1'000'000'000'000LL));
  s.noise = settings.take_number("noise", s.noise, 0, 30);
  s.drift = settings.take_number("drift", s.drift, -60, 60);
  s.flicker = settings.take_number("flicker", s.flicker, 0, 30);
  s.shake = settings.take_number("shake", s.shake, 0, 10);
  s.depth = settings.take_flag("depth", s.depth);
  s.empty = settings.take_number("empty", s.empty, 0, 60);
  s.tail = settings.take_number("tail", s.tail, 0, 60);
  const double natural = synthetic::script_facts(request.script).duration;
  const bool given = uri.settings.contains("duration");
  const double duration = settings.take_number("duration", natural, 0, 36000);
  if (given) s.duration = duration;
  s.text = settings.take_text("text", "");
  s.letters_per_minute = settings.take_number("rate", s.letters_per_minute, 4, 60);
  s.build = settings.take_choice("build", s.build, synthetic::build_names());
  s.skin = settings.take_choice("skin", s.skin, synthetic::skin_names());
  s.clothes = settings.take_choice("clothes", s.clothes, synthetic::clothes_names());
  s.sleeves = settings.take_choice("sleeves", s.sleeves, synthetic::sleeves_names());
  s.room = settings.take_choice("room", s.room, synthetic::room_names());
  s.light = settings.take_choice("light", s.light, synthetic::light_names());
  s.poster = settings.take_flag("poster", s.poster);
  s.flags = settings.take_flag("flags", s.flags);
  s.distance = settings.take_number("distance", s.distance, 0.6, 2.5);
  s.place = settings.take_number("place", s.place, -0.35, 0.35);
  s.pan = parse_pan(uri, settings.take_text("pan", "0:0:1"));
  s.exposure = settings.take_number("exposure", s.exposure, 0.5, 1.5);
  settings.refuse_the_rest();
  s.validate();
  return request;
}

PerformerRequest performer_request(const SourceUri& uri) {
  SettingReader settings(uri);
  return performer_request(uri, settings);
}

Driver synthetic_driver() {
  Driver driver;
  driver.scheme = "synthetic";
  driver.example = "synthetic://jumping-jacks?size=640x480&seed=2";
  driver.summary = "a drawn performer with a known choreography";
  driver.open = [](const SourceUri& uri, SettingReader& settings, const OpenOptions&) -> std::unique_ptr<Source> {
    return std::make_unique<SyntheticSource>(uri, performer_request(uri, settings));
  };
  return driver;
}

}  // namespace choreo::devices
