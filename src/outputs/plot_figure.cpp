// SPDX-License-Identifier: Apache-2.0
#include "outputs/plot_figure.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace choreo::outputs {
namespace {

// The page in ems. An em is 1/75 of the width: 7 points where the figure is printed over both columns (183 mm).
constexpr double kEmsAcross = 75.0;
constexpr double kLeastEmPx = 9.0;
constexpr double kLeft = 5.6;
constexpr double kRight = 2.4;
constexpr double kTop = 1.6;
constexpr double kBottom = 1.4;
constexpr double kTitleSize = 1.25;
constexpr double kSmall = 0.85;
constexpr double kTick = 0.45;
constexpr double kKeySide = 5.2;
constexpr double kKeyNumbers = 3.4;  // Room for the numbers beside the key, 0.123 at the widest.
constexpr double kThumbnailHeight = 6.0;
constexpr double kLabelRow = 1.75;  // From the axis to the base line of its labels.
constexpr double kTitleRow = 3.4;   // From the axis to the base line of its title.
constexpr double kCap = 0.36;       // Half the height of a digit: base line to middle.

}  // namespace

FigureGrid figure_grid(int width_px) {
  FigureGrid grid;
  grid.em = std::max(kLeastEmPx, width_px / kEmsAcross);
  grid.left = static_cast<int>(std::lround(kLeft * grid.em));
  const int room = width_px - grid.left - static_cast<int>(std::lround(kRight * grid.em));
  grid.raster = room - room % 2;
  return grid;
}

Figure::Figure(const similarity::PlotRaster& raster, std::size_t frames, const std::vector<Thumbnail>& thumbnails,
               const PlotOptions& options, ValueRange range)
    : raster_(raster), options_(options), range_(range) {
  const auto grid = figure_grid(options.width_px);
  em_ = grid.em;
  thin_ = std::max(1.0, std::round(em_ * 0.07));
  hair_ = std::max(1.0, std::round(em_ * 0.035));
  // Sand and indigo are no mixture of black, red, cyan and white, and near enough to the page to stand back.
  inks_ =
      options.dark
          ? Inks{{0.07, 0.075, 0.085}, {0.93, 0.93, 0.92}, {0.66, 0.67, 0.68}, {0.36, 0.37, 0.40}, {0.19, 0.19, 0.31}}
          : Inks{{1, 1, 1}, {0.10, 0.10, 0.11}, {0.38, 0.39, 0.41}, {0.80, 0.80, 0.81}, {0.90, 0.86, 0.78}};
  gaps_ = similarity::has_gaps(raster, options.channels);
  data_x_ = grid.left;
  data_width_ = static_cast<double>(raster.width);
  data_height_ = static_cast<double>(raster.height);

  title_ = printable(options.title);
  // How long a single frame lasts nobody knows.
  facts_ =
      frames == 1 ? "1 frame" : fmt::format("{} frames, {}", frames, describe_duration(raster.end_s - raster.begin_s));
  subtitle_ = printable(options.subtitle);
  for (const auto& t : thumbnails) {
    if (t.time_s >= raster.begin_s && t.time_s <= raster.end_s) placed_.push_back({&t, time_to_x(t.time_s), {}});
  }
  set_header();
  place_thumbnails();
}

void Figure::set_header() {
  // A triangle leaves its upper right corner to the key, a square has the key beside the title.
  const double room = data_width_ - (triangle() ? 0.0 : key_width() + 2.0 * em_);
  title_ = meter_.shortened(title_, kTitleSize * em_, true, room);
  facts_ = meter_.shortened(facts_, em_, false, room);
  subtitle_ = meter_.shortened(subtitle_, em_, false, room);
  double y = kTop * em_;
  if (!title_.empty()) y += 1.75 * em_;
  y += 1.5 * em_;
  if (!subtitle_.empty()) y += 1.5 * em_;
  key_top_ = (triangle() ? y + 0.8 * em_ : kTop * em_);
  if (!triangle()) {
    const double key = options_.channels == PlotChannels::kBoth ? kKeySide + 1.2 : 4.0;
    y = std::max(y, (kTop + key) * em_);
    if (!placed_.empty()) y += (kThumbnailHeight + 1.4) * em_;
  }
  data_y_ = std::round(y + (triangle() ? 0.9 : 1.0) * em_);
  double bottom = data_y_ + data_height_ + kTitleRow * em_;
  if (triangle() && !placed_.empty()) bottom += (1.0 + kThumbnailHeight) * em_;
  height_ = static_cast<int>(std::ceil(bottom + kBottom * em_));
}

void Figure::place_thumbnails() {
  const double top =
      triangle() ? data_y_ + data_height_ + (kTitleRow + 1.0) * em_ : data_y_ - (kThumbnailHeight + 1.2) * em_;
  std::stable_sort(placed_.begin(), placed_.end(), [](const auto& a, const auto& b) { return a.x < b.x; });
  double free_from = 0.3 * em_;
  std::vector<PlacedThumbnail> kept;
  for (auto t : placed_) {
    const double scale = kThumbnailHeight * em_ / std::max(t.what->picture.rows, t.what->picture.cols / 2);
    t.box.width = t.what->picture.cols * scale;
    t.box.height = t.what->picture.rows * scale;
    t.box.x = std::clamp(t.x - t.box.width / 2.0, 0.3 * em_, std::max(0.3 * em_, width() - 0.3 * em_ - t.box.width));
    // Feet on one line above a square, heads on one line below a triangle: next to the leader.
    t.box.y = triangle() ? top : top + kThumbnailHeight * em_ - t.box.height;
    if (t.box.x < free_from) continue;
    free_from = t.box.x + t.box.width + 0.4 * em_;
    kept.push_back(t);
  }
  placed_ = std::move(kept);
}

double Figure::time_to_x(double seconds) const {
  return data_x_ + data_width_ * (seconds - raster_.begin_s) / (raster_.end_s - raster_.begin_s);
}

cv::Rect Figure::raster_box() const {
  return {static_cast<int>(data_x_), static_cast<int>(data_y_), static_cast<int>(data_width_),
          static_cast<int>(data_height_)};
}

void Figure::draw(Canvas& canvas) const {
  canvas.fill({0.0, 0.0, static_cast<double>(width()), static_cast<double>(height())}, inks_.page);
  draw_header(canvas);
  draw_outline(canvas);
  draw_axes(canvas);
  draw_raster(canvas);
  draw_key(canvas);
}

void Figure::line(Canvas& canvas, Point from, Point to, double width, Rgb color) const {
  // Odd widths are sharp between pixels, even ones on them.
  const double nudge = std::fmod(width, 2.0) / 2.0;
  const auto snap = [nudge](double v) { return std::floor(v - nudge + 0.5) + nudge; };
  if (from.x == to.x) from.x = to.x = snap(from.x);
  if (from.y == to.y) from.y = to.y = snap(from.y);
  const Point points[] = {from, to};
  canvas.stroke(points, false, width, color);
}

void Figure::draw_header(Canvas& canvas) const {
  double y = kTop * em_;
  if (!title_.empty()) {
    canvas.text({data_x_, y + em_}, title_, {.size = kTitleSize * em_, .color = inks_.text, .bold = true});
    y += 1.75 * em_;
  }
  canvas.text({data_x_, y + em_}, facts_, {.size = em_, .color = inks_.text});
  y += 1.5 * em_;
  if (!subtitle_.empty()) canvas.text({data_x_, y + em_}, subtitle_, {.size = em_, .color = inks_.quiet});
}

void Figure::draw_raster(Canvas& canvas) const {
  const auto byte = [](double v) { return static_cast<std::uint8_t>(std::lround(255.0 * v)); };
  const auto picture =
      similarity::paint(raster_, options_.channels, range_, {byte(inks_.gap.b), byte(inks_.gap.g), byte(inks_.gap.r)});
  canvas.image(picture, {data_x_, data_y_, data_width_, data_height_}, Scaling::kCrisp,
               triangle() ? corners() : std::vector<Point>{});
}

std::vector<Point> Figure::corners() const {
  const double left = data_x_, right = left + data_width_, top = data_y_, bottom = top + data_height_;
  if (triangle()) return {{left, bottom}, {(left + right) / 2.0, top}, {right, bottom}};
  return {{left, top}, {right, top}, {right, bottom}, {left, bottom}};
}

/// White on a white page and black on a dark one end somewhere too. The raster covers the inner half of the line.
void Figure::draw_outline(Canvas& canvas) const { canvas.stroke(corners(), true, 2.0 * hair_, inks_.hair); }

TimeTicks Figure::choose_ticks(double begin_s, double end_s, double pixels, bool across) const {
  const double px_per_s = pixels / (end_s - begin_s);
  double least = 4.5 * em_ / px_per_s;
  for (;;) {
    auto ticks = time_ticks(begin_s, end_s, least);
    double widest = 0.0;
    for (const auto& t : ticks.ticks) widest = std::max(widest, meter_.width(t.label, em_));
    if (!across || ticks.ticks.size() < 2 || widest + 1.7 * em_ <= ticks.step_s * px_per_s) return ticks;
    least = ticks.step_s * 1.01;
  }
}

void Figure::draw_axes(Canvas& canvas) const {
  std::vector<Obstacle> obstacles;
  draw_time_axis(canvas, obstacles);
  draw_side_axis(canvas);
  draw_thumbnails(canvas, obstacles);
}

void Figure::draw_time_axis(Canvas& canvas, std::vector<Obstacle>& obstacles) const {
  const double axis = data_y_ + data_height_;
  const auto ticks = choose_ticks(raster_.begin_s, raster_.end_s, data_width_, true);
  line(canvas, {data_x_, axis + thin_ / 2}, {data_x_ + data_width_, axis + thin_ / 2}, thin_, inks_.text);
  for (const auto& t : ticks.ticks) {
    const double x = time_to_x(t.at_s);
    line(canvas, {x, axis}, {x, axis + kTick * em_}, thin_, inks_.text);
    canvas.text({x, axis + kLabelRow * em_}, t.label, {.size = em_, .color = inks_.text, .anchor = Anchor::kMiddle});
    const double half = meter_.width(t.label, em_) / 2.0;
    obstacles.push_back({x - half, x + half, axis + 0.6 * em_, axis + 2.0 * em_});
  }
  const auto title = fmt::format("time ({})", ticks.unit);
  const double x = data_x_ + data_width_ / 2.0;
  canvas.text({x, axis + kTitleRow * em_}, title, {.size = em_, .color = inks_.text, .anchor = Anchor::kMiddle});
  const double half = meter_.width(title, em_) / 2.0;
  obstacles.push_back({x - half, x + half, axis + 2.4 * em_, axis + 3.8 * em_});
}

void Figure::draw_side_axis(Canvas& canvas) const {
  const double span = raster_.end_s - raster_.begin_s;
  const double first = triangle() ? 0.0 : raster_.begin_s;
  // In a square the same ticks as across.
  const auto ticks = choose_ticks(first, first + span, data_height_, !triangle());
  line(canvas, {data_x_ - thin_ / 2, data_y_}, {data_x_ - thin_ / 2, data_y_ + data_height_ + thin_}, thin_,
       inks_.text);
  double widest = 0.0;
  for (const auto& t : ticks.ticks) {
    widest = std::max(widest, meter_.width(t.label, em_));
    const double share = (t.at_s - first) / span;
    const double y = data_y_ + data_height_ * (triangle() ? 1.0 - share : share);
    line(canvas, {data_x_ - kTick * em_, y}, {data_x_, y}, thin_, inks_.text);
    if (triangle() && share > 0.0) {
      line(canvas, {data_x_, y}, {data_x_ + share * data_width_ / 2.0, y}, hair_, inks_.hair);
    }
    canvas.text({data_x_ - 0.75 * em_, y + kCap * em_}, t.label,
                {.size = em_, .color = inks_.text, .anchor = Anchor::kEnd});
  }
  canvas.text({std::max(0.9 * em_, data_x_ - widest - 1.7 * em_), data_y_ + data_height_ / 2.0},
              fmt::format("{} ({})", triangle() ? "lag" : "time", ticks.unit),
              {.size = em_, .color = inks_.text, .anchor = Anchor::kMiddle, .upwards = true});
}

void Figure::draw_thumbnails(Canvas& canvas, const std::vector<Obstacle>& obstacles) const {
  for (const auto& t : placed_) {
    const double foot = std::clamp(t.x, t.box.x, t.box.x + t.box.width);
    if (triangle()) {
      // Down from the axis, with a break where the leader would strike out a number.
      double from = data_y_ + data_height_;
      for (const auto& o : obstacles) {
        if (t.x < o.left - 0.2 * em_ || t.x > o.right + 0.2 * em_ || o.top < from) continue;
        line(canvas, {t.x, from}, {t.x, o.top}, hair_, inks_.quiet);
        from = o.bottom;
      }
      const double knee = std::max(from, t.box.y - 0.6 * em_);
      line(canvas, {t.x, from}, {t.x, knee}, hair_, inks_.quiet);
      line(canvas, {t.x, knee}, {foot, t.box.y}, hair_, inks_.quiet);
    } else {
      line(canvas, {t.x, data_y_}, {t.x, data_y_ - 0.5 * em_}, hair_, inks_.quiet);
      line(canvas, {t.x, data_y_ - 0.5 * em_}, {foot, data_y_ - 1.1 * em_}, hair_, inks_.quiet);
    }
    canvas.image(t.what->picture, t.box, Scaling::kSmooth);
  }
}

double Figure::key_width() const {
  const double plate = options_.channels == PlotChannels::kBoth ? kKeySide + 2.6 : 11.0;
  const bool beside = gaps_ && options_.channels == PlotChannels::kBoth;
  return plate * em_ + (beside ? kKeyNumbers * em_ + meter_.width(options_.gap, kSmall * em_) : 0.0);
}

void Figure::draw_key(Canvas& canvas) const {
  const double right = data_x_ + data_width_;
  if (options_.channels == PlotChannels::kBoth) {
    draw_square_key(canvas, right, key_top_);
  } else {
    draw_grey_key(canvas, right, key_top_);
  }
}

/// Every colour there is: Z to the right, Z* upwards.
void Figure::draw_square_key(Canvas& canvas, double right, double top) const {
  const double side = std::round(kKeySide * em_);
  const double x = std::round(right - side), y = std::round(top);
  canvas.image(similarity::colour_key(), {x, y, side, side}, Scaling::kSmooth);
  const Point frame[] = {{x, y}, {x + side, y}, {x + side, y + side}, {x, y + side}};
  canvas.stroke(frame, true, hair_, inks_.quiet);

  const auto lo = fmt::format("{:.3g}", range_.lo), hi = fmt::format("{:.3g}", range_.hi);
  const TextStyle number = {.size = kSmall * em_, .color = inks_.quiet};
  const auto put = [&](Point at, std::string_view text, Anchor anchor, bool name) {
    auto style = number;
    style.anchor = anchor;
    if (name) style = {.size = em_, .color = inks_.text, .anchor = anchor, .bold = true};
    canvas.text(at, text, style);
  };
  const double under = y + side + 1.05 * em_;
  put({x, under}, lo, Anchor::kStart, false);
  put({x + side, under}, hi, Anchor::kEnd, false);
  put({x + side / 2, under}, "Z", Anchor::kMiddle, true);
  const double beside = x - 0.4 * em_;
  put({beside, y + 0.65 * em_}, hi, Anchor::kEnd, false);
  put({beside, y + side}, lo, Anchor::kEnd, false);
  put({beside, y + side / 2 + kCap * em_}, "Z*", Anchor::kEnd, true);
  if (!gaps_) return;
  const double swatch = std::round(0.9 * em_);
  const double text_x = x - kKeyNumbers * em_;
  const double swatch_x = std::round(text_x - meter_.width(options_.gap, kSmall * em_) - 0.45 * em_ - swatch);
  canvas.fill({swatch_x, y + side - swatch, swatch, swatch}, inks_.gap);
  put({text_x, y + side - 0.12 * em_}, options_.gap, Anchor::kEnd, false);
}

void Figure::draw_grey_key(Canvas& canvas, double right, double top) const {
  const double width = std::round(9.0 * em_), height = std::round(em_);
  const double x = std::round(right - width), y = std::round(top);
  cv::Mat ramp(1, 256, CV_8UC3);
  for (int col = 0; col < 256; ++col) ramp.at<cv::Vec3b>(0, col) = cv::Vec3b::all(static_cast<std::uint8_t>(col));
  canvas.image(ramp, {x, y, width, height}, Scaling::kSmooth);
  const Point frame[] = {{x, y}, {x + width, y}, {x + width, y + height}, {x, y + height}};
  canvas.stroke(frame, true, hair_, inks_.quiet);
  const TextStyle number = {.size = kSmall * em_, .color = inks_.quiet};
  const double under = y + height + 1.05 * em_;
  canvas.text({x, under}, fmt::format("{:.3g}", range_.lo), number);
  canvas.text({x + width, under}, fmt::format("{:.3g}", range_.hi),
              {.size = number.size, .color = number.color, .anchor = Anchor::kEnd});
  canvas.text({x + width / 2, under + 0.05 * em_}, options_.channels == PlotChannels::kZ ? "Z" : "Z*",
              {.size = em_, .color = inks_.text, .anchor = Anchor::kMiddle, .bold = true});
  if (!gaps_) return;
  const double swatch = std::round(0.9 * em_);
  const double text_x = right - meter_.width(options_.gap, kSmall * em_);
  canvas.fill({std::round(text_x - 0.45 * em_ - swatch), under + 0.9 * em_, swatch, swatch}, inks_.gap);
  canvas.text({right, under + 0.9 * em_ + swatch - 0.12 * em_}, options_.gap,
              {.size = number.size, .color = number.color, .anchor = Anchor::kEnd});
}

}  // namespace choreo::outputs
