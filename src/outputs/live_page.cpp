// SPDX-License-Identifier: Apache-2.0
#include "outputs/live_page.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "outputs/plot_ticks.hpp"
#include "similarity/plot_raster.hpp"

namespace choreo::outputs {
namespace {

// A dark page: it is looked at beside a stage, or projected. The same inks as a dark plot.
constexpr Rgb kPage{0.07, 0.075, 0.085};
constexpr Rgb kText{0.93, 0.93, 0.92};
constexpr Rgb kQuiet{0.66, 0.67, 0.68};
constexpr Rgb kHair{0.30, 0.31, 0.34};
constexpr Rgb kGap{0.19, 0.19, 0.31};
constexpr Rgb kBlank{0.105, 0.11, 0.12};

constexpr double kKeySide = 5.0;     // Ems.
constexpr double kLineHeight = 1.5;  // Ems.

cv::Vec3b bgr_of(Rgb c) {
  const auto byte = [](double v) { return static_cast<std::uint8_t>(std::lround(255.0 * v)); };
  return {byte(c.b), byte(c.g), byte(c.r)};
}

void draw_key(Canvas& canvas, const LiveLayout& layout) {
  const double em = layout.em;
  const double side = kKeySide * em;
  const Box box{layout.figures.x + layout.figures.width - side, layout.figures.y, side, side};
  canvas.image(similarity::colour_key(), box, Scaling::kSmooth);
  canvas.text({box.x + side / 2, box.y + side + 1.15 * em}, "Z",
              {.size = em, .color = kText, .anchor = Anchor::kMiddle, .bold = true});
  canvas.text({box.x - 0.4 * em, box.y + side / 2 + 0.36 * em}, "Z*",
              {.size = em, .color = kText, .anchor = Anchor::kEnd, .bold = true});
}

// Ticks of the past: 0 is now, at the right end.
void draw_time_axis(Canvas& canvas, const LiveLayout& layout, double span_s) {
  const double em = layout.em;
  const auto& t = layout.triangle;
  const double axis = t.y + t.height;
  const auto ticks = time_ticks(0, span_s, 5.0 * em * span_s / t.width);
  for (const auto& tick : ticks.ticks) {
    const double x = t.x + t.width * (1.0 - tick.at_s / span_s);
    const Point mark[] = {{x, axis}, {x, axis + 0.4 * em}};
    canvas.stroke(mark, false, 1.0, kQuiet);
    canvas.text({x, axis + 1.5 * em}, tick.at_s == 0 ? "now" : "\u2212" + tick.label,
                {.size = em, .color = kText, .anchor = Anchor::kMiddle});
  }
  canvas.text({t.x + t.width / 2, axis + 2.8 * em}, fmt::format("time ({})", ticks.unit),
              {.size = em, .color = kQuiet, .anchor = Anchor::kMiddle});
}

void draw_lags(Canvas& canvas, const LiveLayout& layout, double span_s) {
  const double em = layout.em;
  const auto& t = layout.triangle;
  const auto ticks = time_ticks(0, span_s, 4.0 * em * span_s / t.height);
  for (const auto& tick : ticks.ticks) {
    const double share = tick.at_s / span_s;
    const double y = t.y + t.height * (1.0 - share);
    // The video and the figures stand above; a label there would be struck out.
    if (tick.at_s == 0 || y < layout.video.y + layout.video.height + 1.2 * em) continue;
    const Point line[] = {{t.x, y}, {t.x + share * t.width / 2, y}};
    canvas.stroke(line, false, 1.0, kHair);
    canvas.text({t.x - 0.5 * em, y + 0.36 * em}, tick.label, {.size = em, .color = kText, .anchor = Anchor::kEnd});
  }
  canvas.text({t.x - 0.5 * em, t.y + t.height + 0.36 * em}, fmt::format("lag ({})", ticks.unit),
              {.size = em, .color = kQuiet, .anchor = Anchor::kEnd});
}

}  // namespace

LiveLayout live_layout(int width, int height, cv::Size video, Leading leading) {
  constexpr double kBesideVideo = 12;  // Ems that are left to key and figures.
  const bool video_leads = leading == Leading::kVideo;
  LiveLayout layout;
  const double em = std::max(9.0, height / 46.0);
  layout.em = em;
  const double left = 5.2 * em, right = 2.0 * em, top = 1.2 * em, bottom = 3.6 * em;
  const double room = width - left - right;
  const double wide = std::max(2.0, std::min(video_leads ? room / 2 : room, 2.0 * (height - top - bottom)));
  const double x = video_leads ? width - right - wide : left + (room - wide) / 2;
  layout.triangle = {x, height - bottom - wide / 2, wide, wide / 2};

  // The corner that the triangle's side leaves free, all but a margin: width + height of what fits is fixed.
  const double sides = layout.triangle.x + layout.triangle.y + layout.triangle.height - 2 * top - 2 * em;
  const double aspect = double(std::max(1, video.width)) / double(std::max(1, video.height));
  const double widest = video_leads ? width - 2 * top - (kBesideVideo + 1) * em : sides;
  const double highest = (video_leads ? 0.8 : 0.6) * height;
  const double high = std::max(1.0, std::min({sides / (1.0 + aspect), highest, widest / aspect}));
  layout.video = {top, top, high * aspect, high};

  // On the right as much as lies beside the triangle's other side, below the lowest line.
  const double lines = 9.0 * em;
  const double base = layout.triangle.y + layout.triangle.height;
  const double side = layout.triangle.x + layout.triangle.width - (base - top - lines) + em;
  const double beside = video_leads ? top + layout.video.width + em : 0;
  layout.figures.width = std::clamp(width - top - std::max(side, beside), 1.0, 26.0 * em);
  layout.figures.height = lines;
  layout.figures.x = width - top - layout.figures.width;
  layout.figures.y = top;
  return layout;
}

cv::Mat draw_live_page(const LiveLayout& layout, int width, int height, double span_s) {
  PixelCanvas canvas(width, height);
  canvas.fill({0, 0, double(width), double(height)}, kPage);
  draw_lags(canvas, layout, span_s);
  draw_time_axis(canvas, layout, span_s);
  draw_key(canvas, layout);
  return canvas.bgr();
}

cv::Mat draw_live_figures(const LiveLayout& layout, const std::vector<std::string>& lines) {
  const double em = layout.em;
  // The key stands to the right of the lines.
  const double room = std::max(1.0, layout.figures.width - (kKeySide + 2.2) * em);
  const int width = std::max(1, static_cast<int>(room));
  const int height = std::max(1, static_cast<int>(layout.figures.height));
  PixelCanvas canvas(width, height);
  canvas.fill({0, 0, double(width), double(height)}, kPage);
  const TextMeter meter;
  double y = em;
  bool first = true;
  for (const auto& line : lines) {
    const auto text = meter.shortened(printable(line), em, first, width);
    canvas.text({double(width), y}, text,
                {.size = em, .color = first ? kText : kQuiet, .anchor = Anchor::kEnd, .bold = first});
    y += kLineHeight * em;
    first = false;
  }
  return canvas.bgr();
}

cv::Vec3b live_blank_colour() { return bgr_of(kBlank); }
cv::Vec3b live_gap_colour() { return bgr_of(kGap); }

}  // namespace choreo::outputs
