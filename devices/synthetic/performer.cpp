// SPDX-License-Identifier: Apache-2.0
#include "devices/synthetic/performer.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/text.hpp"
#include "devices/synthetic/brush.hpp"
#include "devices/synthetic/chance.hpp"
#include "devices/synthetic/depth_camera.hpp"
#include "devices/synthetic/mannequin.hpp"
#include "devices/synthetic/room.hpp"

namespace choreo::devices::synthetic {
namespace {

constexpr int kScale = 1 << kLevelBits;
constexpr int kTableBits = 18;
constexpr int kRun = 480;  // bytes of a row that take their noise from one place of the table

// Normal numbers in 1/32 grey levels; long enough that a run may start anywhere in the first 2^18.
std::vector<short> noise_table(std::uint64_t seed, double deviation) {
  std::vector<short> table;
  if (deviation <= 0) return table;
  table.resize((std::size_t{1} << kTableBits) + kRun);
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double level = std::clamp(normal(mixed(seed, 301, i)), -6.0, 6.0) * deviation * kScale;
    table[i] = static_cast<short>(std::lround(level));
  }
  return table;
}

unsigned char to_byte(int fixed) {
  return static_cast<unsigned char>(std::clamp((fixed + kScale / 2) >> kLevelBits, 0, 255));
}

void check(double value, double least, double most, const char* name) {
  if (!(value >= least && value <= most)) {
    throw usage_error(fmt::format("{} is {}", name, value), {}, fmt::format("{} is from {} to {}", name, least, most));
  }
}

void check(const std::string& value, std::span<const std::string> names, const char* name) {
  if (std::find(names.begin(), names.end(), value) == names.end()) {
    throw usage_error(fmt::format("{} is \"{}\"", name, value), {}, hint_for_name(value, names));
  }
}

}  // namespace

void PerformerSettings::validate() const {
  const auto [shorter, longer] = std::minmax(size.width, size.height);
  if (shorter < 16 || shorter > 2160 || longer > 3840) {
    throw usage_error(fmt::format("size is {}x{}", size.width, size.height), {}, "size is from 16x16 to 3840x2160");
  }
  check(fps, 1, 240, "fps");
  check(noise, 0, 30, "noise");
  check(drift, -60, 60, "drift");
  check(flicker, 0, 30, "flicker");
  check(shake, 0, 10, "shake");
  check(empty, 0, 60, "empty");
  check(tail, 0, 60, "tail");
  if (duration) check(*duration, 0, 36000, "duration");
  check(letters_per_minute, 4, 60, "rate");
  check(build, build_names(), "build");
  check(skin, skin_names(), "skin");
  check(clothes, clothes_names(), "clothes");
  check(sleeves, sleeves_names(), "sleeves");
  check(room, room_names(), "room");
  check(light, light_names(), "light");
  check(distance, 0.6, 2.5, "distance");
  check(place, -0.35, 0.35, "place");
  check(pan.dx, -64, 64, "pan to the right");
  check(pan.dy, -64, 64, "pan down");
  check(pan.zoom, 0.9, 1.1, "zoom of pan");
  check(exposure, 0.5, 1.5, "exposure");
  if (depth && (distance != 1 || pan.zoom != 1)) {
    throw usage_error("depth goes with distance 1 and a pan without zoom only");
  }
}

struct Performer::Film {
  Film(std::string_view name, const PerformerSettings& s)
      : settings((s.validate(), s)),
        stage(zoomed_stage(moved_stage(make_stage(s.size), s.distance, s.place), s.pan.zoom)),
        script(name, options_for(s, stage)),
        look(look_of(s)),
        margin(margin_of(s)),
        room(paint_room(make_stage(s.size), look, {furniture_named(s.room), s.poster}, s.seed, margin, !s.pan.none())),
        gain(gain_of(s)),
        noise(noise_table(s.seed, s.noise)),
        depth_camera(s.depth ? std::make_unique<DepthCamera>(stage, look, s.seed) : nullptr),
        empty_frames(static_cast<int>(std::lround(s.empty * s.fps))),
        played_frames(static_cast<int>(std::lround(s.duration.value_or(script.duration()) * s.fps))),
        tail_frames(static_cast<int>(std::lround(s.tail * s.fps))) {}

  static ScriptOptions options_for(const PerformerSettings& s, const Stage& stage) {
    ScriptOptions options;
    options.seed = s.seed;
    if (!s.text.empty()) options.text = s.text;
    options.letters_per_minute = s.letters_per_minute;
    options.half_width = stage.half_width() + std::abs(s.place) * s.size.width / stage.unit;
    return options;
  }

  static Look look_of(const PerformerSettings& s) {
    auto look = choose_look(s.seed, s.build, s.skin, s.clothes);
    look.sleeves = sleeves_named(s.sleeves);
    look.flags = s.flags;
    return look;
  }

  // For any pan the same, so that the same room is painted.
  static int margin_of(const PerformerSettings& s) {
    const int shaken = s.shake > 0 ? static_cast<int>(std::ceil(4 * s.shake)) + 2 : 0;
    if (s.pan.none()) return shaken;
    constexpr double kPan = 64, kZoomOut = 0.9;
    const double side = std::max(s.size.width, s.size.height) / 2.0;
    return static_cast<int>(std::ceil((shaken + kPan + side) / kZoomOut - side)) + 2;
  }

  // In 1/256, blue green red.
  static cv::Vec3i gain_of(const PerformerSettings& s) {
    const auto light = light_named(s.light) * s.exposure;
    return {cvRound(light[0] * 256), cvRound(light[1] * 256), cvRound(light[2] * 256)};
  }

  // How far the camera displaces the picture: right and down, in pixels.
  [[nodiscard]] cv::Point2d shift_at(int index) const {
    const cv::Point2d pan(settings.pan.dx, settings.pan.dy);
    if (settings.shake <= 0) return pan;
    const auto along = [&](std::uint64_t axis) {
      return std::clamp(normal(mixed(settings.seed, 311, static_cast<std::uint64_t>(index), axis)), -4.0, 4.0);
    };
    return pan + cv::Point2d(settings.shake * along(0), settings.shake * along(1));
  }

  // What the light adds at a time, in 1/32 grey levels.
  [[nodiscard]] int light_at(double seconds) const {
    const double levels = settings.drift * seconds / 60 +
                          settings.flicker * std::sin(2 * std::numbers::pi * std::fmod(100 * seconds, 1.0));
    return static_cast<int>(std::lround(std::clamp(levels, -255.0, 255.0) * kScale));
  }

  // A row of the room as the shaken camera sees it. The table `row` has room for three values a pixel.
  void room_row(int y, cv::Point2d shift, std::vector<int>& row) const {
    const auto values = static_cast<std::size_t>(settings.size.width) * 3;
    if (margin == 0) {
      const auto* from = room.ptr<short>(y);
      std::copy(from, from + values, row.begin());
      return;
    }
    if (settings.pan.zoom != 1) {
      zoomed_row(y, shift, row);
      return;
    }
    const double source_x = margin - shift.x;
    const double source_y = y + margin - shift.y;
    const int x0 = static_cast<int>(std::floor(source_x));
    const int y0 = static_cast<int>(std::floor(source_y));
    const int fx = static_cast<int>((source_x - x0) * 64);
    const int fy = static_cast<int>((source_y - y0) * 64);
    const auto* a = room.ptr<short>(y0) + static_cast<std::ptrdiff_t>(x0) * 3;
    const auto* b = room.ptr<short>(y0 + 1) + static_cast<std::ptrdiff_t>(x0) * 3;
    for (std::size_t i = 0; i < values; ++i) {
      const int upper = a[i] * (64 - fx) + a[i + 3] * fx;
      const int lower = b[i] * (64 - fx) + b[i + 3] * fx;
      row[i] = (upper * (64 - fy) + lower * fy) >> 12;
    }
  }

  // The same where the picture is enlarged about its centre, before it is displaced.
  void zoomed_row(int y, cv::Point2d shift, std::vector<int>& row) const {
    const double per_pixel = 1 / settings.pan.zoom;
    const auto source = [&](int at, double displaced, int size) {
      const double centre = (size - 1) / 2.0;
      return margin + centre + (at - displaced - centre) * per_pixel;
    };
    const double source_y = source(y, shift.y, settings.size.height);
    const int y0 = static_cast<int>(std::floor(source_y));
    const int fy = static_cast<int>((source_y - y0) * 64);
    const auto* upper = room.ptr<cv::Vec3s>(y0);
    const auto* lower = room.ptr<cv::Vec3s>(y0 + 1);
    for (int x = 0; x < settings.size.width; ++x) {
      const double source_x = source(x, shift.x, settings.size.width);
      const int x0 = static_cast<int>(std::floor(source_x));
      const int fx = static_cast<int>((source_x - x0) * 64);
      for (int c = 0; c < 3; ++c) {
        const int above = upper[x0][c] * (64 - fx) + upper[x0 + 1][c] * fx;
        const int below = lower[x0][c] * (64 - fx) + lower[x0 + 1][c] * fx;
        row[static_cast<std::size_t>(3 * x + c)] = (above * (64 - fy) + below * fy) >> 12;
      }
    }
  }

  // What falls on everything: the light's colour and strength, and the exposure.
  void light_row(std::vector<int>& row) const {
    if (gain == cv::Vec3i(256, 256, 256)) return;
    for (std::size_t i = 0; i + 2 < row.size(); i += 3) {
      for (int c = 0; c < 3; ++c)
        row[i + static_cast<std::size_t>(c)] = row[i + static_cast<std::size_t>(c)] * gain[c] >> 8;
    }
  }

  // Lays one row of the figure over the room and marks the mask.
  void figure_row(int y, std::vector<int>& row, Performance& out) const {
    auto* mask = out.mask.ptr<unsigned char>(y);
    const std::array bare = {out.bare_arm[0].ptr<unsigned char>(y), out.bare_arm[1].ptr<unsigned char>(y)};
    const auto [first, last] = brush.extent(y);
    const int all = brush.samples_per_pixel();
    for (int x = first; x < last; ++x) {
      const auto sum = brush.pixel(x, y);
      if (sum[3] == 0) continue;
      auto* value = row.data() + static_cast<std::ptrdiff_t>(x) * 3;
      for (int c = 0; c < 3; ++c) {
        value[c] = (value[c] * (all - sum[3]) + sum[static_cast<std::size_t>(c)] * kScale) / all;
      }
      if (2 * sum[3] >= all) {
        mask[x] = 255;
        out.present = true;
        for (const auto side : {body::kLeft, body::kRight}) {
          if (2 * brush.marked(x, y, kBareArmMark[side]) >= all) bare[side][x] = 255;
        }
      }
    }
  }

  // Light and noise, rounded to bytes.
  void expose_row(int index, int y, int light, const std::vector<int>& row, unsigned char* out) const {
    const int values = settings.size.width * 3;
    for (int start = 0, run = 0; start < values; start += kRun, ++run) {
      const int end = std::min(start + kRun, values);
      if (noise.empty()) {
        for (int i = start; i < end; ++i) out[i] = to_byte(row[static_cast<std::size_t>(i)] + light);
        continue;
      }
      const auto place = mixed(settings.seed, static_cast<std::uint64_t>(index), static_cast<std::uint64_t>(y),
                               static_cast<std::uint64_t>(run)) >>
                         (64 - kTableBits);
      const short* from = noise.data() + place;
      const int* level = row.data() + start;
      unsigned char* to = out + start;
      for (int i = 0; i < end - start; ++i) to[i] = to_byte(level[i] + light + from[i]);
    }
  }

  PerformerSettings settings;
  Stage stage;
  Script script;
  Look look;
  int margin;
  cv::Mat room;    // see paint_room
  cv::Vec3i gain;  // see gain_of
  std::vector<short> noise;
  std::unique_ptr<const DepthCamera> depth_camera;  // null: colour alone
  int empty_frames;
  int played_frames;
  int tail_frames;
  mutable Brush brush;  // scratch
};

Performer::Performer(std::string_view script, const PerformerSettings& settings)
    : film_(std::make_unique<Film>(script, settings)) {}
Performer::~Performer() = default;
Performer::Performer(Performer&&) noexcept = default;
Performer& Performer::operator=(Performer&&) noexcept = default;

int Performer::frame_count() const { return film_->empty_frames + film_->played_frames + film_->tail_frames; }
int Performer::first_frame() const { return film_->empty_frames; }
const Script& Performer::script() const { return film_->script; }
const Look& Performer::look() const { return film_->look; }
const PerformerSettings& Performer::settings() const { return film_->settings; }

cv::Mat Performer::room() const {
  const auto& f = *film_;
  cv::Mat picture(f.settings.size, CV_8UC3);
  std::vector<int> row(static_cast<std::size_t>(picture.cols) * 3);
  for (int y = 0; y < picture.rows; ++y) {
    f.room_row(y, {f.settings.pan.dx, f.settings.pan.dy}, row);
    f.light_row(row);
    auto* to = picture.ptr<unsigned char>(y);
    for (const int level : row) *to++ = to_byte(level);
  }
  return picture;
}

Performance Performer::perform(int index) const {
  assert(index >= 0 && index < frame_count());
  const auto& f = *film_;
  Performance out;
  out.bgr.create(f.settings.size, CV_8UC3);
  out.mask = cv::Mat::zeros(f.settings.size, CV_8UC1);
  for (auto& arm : out.bare_arm) arm = cv::Mat::zeros(f.settings.size, CV_8UC1);
  const double seconds = index / f.settings.fps;
  out.time = from_seconds(seconds);
  const int played = index - f.empty_frames;
  std::optional<body::Pose> pose;
  if (played >= 0 && played < f.played_frames) pose = f.script.pose_at(played / f.settings.fps);

  const auto shift = f.shift_at(index);
  const bool drawn = pose && draw_figure(f.brush, *pose, f.look, f.stage, shift);
  std::optional<FloorShadow> shadow;
  if (pose) shadow.emplace(*pose, f.stage, shift);
  const int light = f.light_at(seconds);
  std::vector<int> row(static_cast<std::size_t>(f.settings.size.width) * 3);
  for (int y = 0; y < f.settings.size.height; ++y) {
    f.room_row(y, shift, row);
    if (shadow && y >= shadow->rows().first && y < shadow->rows().second) shadow->darken(y, row);
    const auto& box = f.brush.box();
    if (drawn && y >= box.y && y < box.y + box.height) {
      f.figure_row(y, row, out);
    }
    f.light_row(row);
    f.expose_row(index, y, light, row, out.bgr.ptr<unsigned char>(y));
  }
  if (f.depth_camera) {
    out.depth = f.depth_camera->film(index, out.present ? out.mask : cv::Mat(), pose.value_or(body::Pose()), shift);
  }
  if (out.present) {
    out.pose = *pose;
    out.face = visible_face(f.brush, *pose, f.stage, shift);
    out.sign = f.script.sign_at(played / f.settings.fps);
    const auto values = body::pose_values(*pose);
    for (std::size_t i = 0; i < values.size(); ++i) out.angles.emplace_back(body::pose_value_names()[i], values[i]);
  }
  return out;
}

}  // namespace choreo::devices::synthetic
