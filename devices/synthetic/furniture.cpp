// SPDX-License-Identifier: Apache-2.0
#include "devices/synthetic/furniture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "devices/synthetic/brush.hpp"
#include "devices/synthetic/chance.hpp"
#include "devices/synthetic/head.hpp"
#include "devices/synthetic/look.hpp"

namespace choreo::devices::synthetic {
namespace {

using Colour = cv::Vec3f;

Colour between(const Colour& a, const Colour& b, float share) { return a * (1 - share) + b * share; }

constexpr double kFloor = 0.04;  // where things stand: just before the wall's foot

void oval(Painter& p, double x, double y, double half_width, double half_height, double degrees, const Colour& colour) {
  const double unit = p.stage().unit;
  cv::ellipse(p.picture(), {p.column(x), p.row(y)},
              {std::max(1, cvRound(half_width * unit)), std::max(1, cvRound(half_height * unit))}, degrees, 0, 360,
              shade(colour, 1), cv::FILLED);
}

void books(Painter& p, double left, double right, double bottom, double space, std::uint64_t seed) {
  static const std::array<Colour, 11> kBindings = {
      rgb(190, 36, 40),  rgb(28, 70, 150), rgb(20, 118, 84),  rgb(232, 178, 36), rgb(238, 232, 214), rgb(92, 44, 120),
      rgb(26, 142, 168), rgb(44, 44, 52),  rgb(208, 92, 140), rgb(120, 168, 52), rgb(224, 104, 30)};
  double x = left;
  for (std::uint64_t i = 0; x < right - 0.012; ++i) {
    const auto chance = [&](std::uint64_t what) { return uniform(mixed(seed, what, i)); };
    const double wide = std::min(0.013 + 0.022 * chance(1), right - x);
    if (chance(2) < 0.1) {  // a gap
      x += wide;
      continue;
    }
    const double high = space * (0.62 + 0.33 * chance(3));
    const auto& colour = kBindings.at(static_cast<std::size_t>(chance(4) * kBindings.size()));
    p.block(x, bottom + high, x + wide, bottom, shade(colour, 0.72));
    p.block(x + 0.002, bottom + high, x + wide - 0.002, bottom, shade(colour, 0.95));
    p.block(x + 0.002, bottom + 0.8 * high, x + wide - 0.002, bottom + 0.74 * high, shade(rgb(236, 222, 176), 0.9));
    x += wide;
  }
}

void bookcase(Painter& p, double left, double right, double top, std::uint64_t seed) {
  constexpr int kShelves = 4;
  constexpr double kBoard = 0.012;
  const auto wood = rgb(92, 84, 82);
  p.block(left, top, right, kFloor, shade(wood, 1));
  const double each = (top - kBoard - kFloor - 0.02) / kShelves;
  for (int i = 0; i < kShelves; ++i) {
    const double bottom = kFloor + 0.02 + i * each + kBoard;
    p.block(left + kBoard, bottom + each - kBoard, right - kBoard, bottom, shade(wood, 0.42));
    books(p, left + kBoard, right - kBoard, bottom, each - kBoard, mixed(seed, 221, static_cast<std::uint64_t>(i)));
  }
}

void painting(Painter& p, double left, double top, double right, double bottom) {
  p.block(left, top, right, bottom, shade(rgb(34, 34, 38), 1));
  const double w = right - left, h = top - bottom;
  const auto part = [&](double a, double b, double c, double d, const Colour& colour) {
    p.block(left + w * a, bottom + h * b, left + w * c, bottom + h * d, shade(colour, 1));
  };
  part(0.05, 0.95, 0.95, 0.05, rgb(238, 234, 222));
  part(0.05, 0.95, 0.40, 0.48, rgb(206, 40, 36));
  part(0.46, 0.95, 0.95, 0.72, rgb(30, 80, 168));
  part(0.46, 0.66, 0.72, 0.05, rgb(244, 200, 40));
  part(0.78, 0.40, 0.95, 0.05, rgb(24, 128, 96));
  part(0.05, 0.26, 0.40, 0.05, rgb(40, 40, 44));
}

void window(Painter& p, double left, double top, double right, double bottom) {
  constexpr double kBar = 0.018;
  p.block(left, top, right, bottom, shade(rgb(250, 250, 246), 1));
  const double middle = (left + right) / 2;
  for (const auto& [a, b] : {std::pair{left + kBar, middle - kBar / 2}, std::pair{middle + kBar / 2, right - kBar}}) {
    constexpr int kBands = 24;
    for (int i = 0; i < kBands; ++i) {
      const auto at = [&](int k) { return top - kBar - (top - bottom - 2 * kBar) * k / kBands; };
      p.block(a, at(i), b, at(i + 1),
              shade(between(rgb(96, 156, 226), rgb(222, 234, 246), static_cast<float>(i) / kBands), 1));
    }
    p.block(a, bottom + 0.16, b, bottom + kBar, shade(rgb(60, 116, 62), 1));
    p.block(a, bottom + 0.09, b, bottom + kBar, shade(rgb(96, 152, 70), 1));
  }
  oval(p, left + 0.13, bottom + 0.20, 0.055, 0.075, 0, rgb(36, 88, 48));
  p.block(middle - kBar / 2, top, middle + kBar / 2, bottom, shade(rgb(240, 240, 236), 1));
  p.block(left, (top + bottom) / 2 + kBar / 2, right, (top + bottom) / 2 - kBar / 2, shade(rgb(240, 240, 236), 1));
  p.block(left - 0.02, bottom + 0.01, right + 0.02, bottom - 0.015, shade(rgb(228, 228, 224), 1));
}

void plant(Painter& p, double x, double top) {
  p.block(x - 0.06, kFloor + 0.16, x + 0.06, kFloor, shade(rgb(52, 76, 132), 1));
  p.block(x - 0.07, kFloor + 0.17, x + 0.07, kFloor + 0.14, shade(rgb(68, 96, 156), 1));
  for (int i = 0; i < 13; ++i) {
    const double share = i / 12.0;
    const double lean = (i % 2 == 0 ? -1 : 1) * (0.03 + 0.05 * (1 - share));
    const double y = kFloor + 0.22 + (top - kFloor - 0.22) * share;
    oval(p, x + lean, y, 0.062, 0.020, lean < 0 ? 28 : -28, i % 3 == 0 ? rgb(58, 130, 58) : rgb(30, 92, 46));
  }
}

void sideboard(Painter& p, double left, double right, double top) {
  const auto paint = rgb(24, 104, 116);
  p.block(left, top, right, kFloor + 0.03, shade(paint, 1));
  p.block(left - 0.01, top + 0.012, right + 0.01, top, shade(rgb(236, 236, 228), 1));
  constexpr int kDrawers = 3;
  for (int i = 0; i < kDrawers; ++i) {
    const double bottom = kFloor + 0.045 + i * (top - kFloor - 0.05) / kDrawers;
    const double high = (top - kFloor - 0.05) / kDrawers - 0.014;
    p.block(left + 0.014, bottom + high, right - 0.014, bottom, shade(paint, 1.25));
    p.block((left + right) / 2 - 0.03, bottom + high / 2 + 0.006, (left + right) / 2 + 0.03, bottom + high / 2 - 0.006,
            shade(rgb(240, 200, 60), 1));
  }
}

// A surface whose grain runs across or along, never by more than 6 %.
void wood(Painter& p, double left, double top, double right, double bottom, const Colour& colour, bool upright) {
  p.block(left, top, right, bottom, shade(colour, 1));
  const double from = upright ? left : bottom, to = upright ? right : top;
  constexpr double kGrain = 0.009;
  int k = 0;
  for (double at = from; at < to; at += kGrain, ++k) {
    const double tone = 0.97 + 0.03 * std::sin(1.7 * k) * std::sin(0.61 * k + 1);
    const double end = std::min(to, at + kGrain);
    if (upright) {
      p.block(at, top, end, bottom, shade(colour, tone));
    } else {
      p.block(left, end, right, at, shade(colour, tone));
    }
  }
}

void panel(Painter& p, double left, double top, double right, double bottom, const Colour& colour, bool upright) {
  const double line = std::max(0.006, p.thin() / p.stage().unit);
  p.block(left, top, right, bottom, shade(colour, 0.70));
  p.block(left + line, top - line, right, bottom, shade(colour, 1.03));
  wood(p, left + line, top - line, right - line, bottom + line, colour * 0.95F, upright);
}

void curtain(Painter& p, double left, double top, double right, double bottom, const Colour& cloth,
             const Colour& rail) {
  const int first = p.column(left), last = p.column(right);
  for (int x = first; x < last; ++x) {
    const double share = (x - first) / static_cast<double>(last - first);
    const double fold = 0.90 + 0.085 * std::sin(2 * std::numbers::pi * (5.5 * share + 0.12 * std::sin(9 * share)));
    const double a = left + (right - left) * share;
    p.block(a, top, a + 1.5 / p.stage().unit, bottom, shade(cloth, fold));
  }
  p.block(left - 0.04, top + 0.022, right + 0.04, top - 0.004, shade(rail, 1));
}

void door(Painter& p, double left, double right, double top, const Colour& leaf, const Colour& frame) {
  wood(p, left - 0.03, top + 0.03, right + 0.03, kFloor, frame, true);
  wood(p, left, top, right, kFloor, leaf, true);
  const double middle = (left + right) / 2;
  for (const auto& [above, below] : {std::pair{top - 0.04, 0.66}, std::pair{0.60, 0.36}, std::pair{0.30, 0.11}}) {
    panel(p, left + 0.04, above, middle - 0.02, below, leaf, true);
    panel(p, middle + 0.02, above, right - 0.04, below, leaf, true);
  }
  oval(p, left + 0.022, 0.53, 0.012, 0.012, 0, rgb(120, 116, 104));
}

void cupboard(Painter& p, double left, double right, double top, const Colour& colour) {
  const double middle = (left + right) / 2;
  wood(p, left, top, right, kFloor + 0.02, colour, false);
  p.block(left - 0.012, top + 0.02, right + 0.012, top - 0.004, shade(colour, 0.86));
  panel(p, left + 0.02, top - 0.03, middle - 0.008, kFloor + 0.06, colour, true);
  panel(p, middle + 0.008, top - 0.03, right - 0.02, kFloor + 0.06, colour, true);
  for (const double side : {-1.0, 1.0}) oval(p, middle + side * 0.03, 0.45, 0.008, 0.008, 0, rgb(70, 60, 52));
}

void table(Painter& p, double left, double right, double top, const Colour& colour) {
  for (const double x : {left + 0.02, right - 0.045}) wood(p, x, top, x + 0.025, kFloor - 0.02, colour * 0.9F, true);
  wood(p, left + 0.01, top - 0.02, right - 0.01, top - 0.07, colour * 0.93F, false);
  wood(p, left - 0.02, top + 0.012, right + 0.02, top - 0.02, colour, false);
}

}  // namespace

void clutter(Painter& painter, std::uint64_t seed) {
  bookcase(painter, -0.90, -0.42, 0.82, seed);
  painting(painter, -0.31, 1.21, 0.05, 0.84);
  window(painter, 0.17, 1.21, 0.60, 0.62);
  sideboard(painter, 0.14, 0.60, 0.43);
  // Flowers and bottles on the sideboard, a short shelf by the bookcase.
  painter.block(0.20, 0.53, 0.25, 0.442, shade(rgb(224, 224, 236), 1));
  for (const auto& [dx, dy] : {std::pair{-0.03, 0.02}, {0.0, 0.05}, {0.03, 0.03}, {0.015, 0.0}, {-0.02, 0.06}}) {
    oval(painter, 0.225 + dx, 0.55 + dy, 0.018, 0.018, 0, rgb(214, 30, 58));
  }
  painter.block(0.49, 0.56, 0.525, 0.442, shade(rgb(20, 110, 60), 1));
  painter.block(0.54, 0.53, 0.565, 0.442, shade(rgb(40, 44, 140), 1));
  painter.block(-0.40, 0.535, -0.10, 0.52, shade(rgb(232, 232, 228), 1));
  books(painter, -0.38, -0.12, 0.535, 0.13, mixed(seed, 222));
  // A clock over the bookcase.
  oval(painter, -0.52, 1.06, 0.062, 0.062, 0, rgb(30, 30, 34));
  oval(painter, -0.52, 1.06, 0.052, 0.052, 0, rgb(246, 244, 236));
  painter.block(-0.523, 1.10, -0.517, 1.06, shade(rgb(30, 30, 34), 1));
  painter.block(-0.52, 1.063, -0.49, 1.057, shade(rgb(200, 30, 34), 1));
  plant(painter, 0.76, 0.86);
}

void furnish_in_wood(Painter& painter) {
  const auto tones = skin_tones();
  const auto& own = painter.look().skin;
  const auto lighter = between(own, tones[2], 0.35F);
  const auto near = between(own, tones[3], 0.45F);
  const auto darker = between(own, tones[4], 0.75F);
  cupboard(painter, -0.90, -0.56, 0.80, own);
  curtain(painter, -0.50, 1.20, -0.27, 0.12, own, darker);
  door(painter, 0.36, 0.72, 1.14, near, darker);
  table(painter, 0.10, 0.50, 0.40, lighter);
}

void hang_poster(Painter& painter) {
  constexpr double kLarger = 1.25, kX = -0.70, kChin = 0.94;
  painter.block(kX - 0.125, 1.195, kX + 0.125, 0.855, shade(rgb(36, 40, 52), 1));
  painter.block(kX - 0.115, 1.185, kX + 0.115, 0.865, shade(rgb(150, 186, 204), 1));
  painter.block(kX - 0.085, 0.925, kX + 0.085, 0.865, shade(rgb(60, 60, 110), 1));
  Look sitter;
  sitter.skin = skin_tones()[1];
  sitter.hair = rgb(60, 40, 30);
  sitter.hair_style = HairStyle::kShort;
  painter.block(kX - 0.03, kChin + 0.03, kX + 0.03, 0.90, shade(sitter.skin, 0.8));
  const double unit = kLarger * painter.stage().unit;
  const cv::Point2d chin(painter.column(kX), painter.row(kChin));
  const cv::Point2d crown(chin.x, chin.y - unit * body::vitruvian::kHeadHeight);
  auto& picture = painter.picture();
  const auto half = cvCeil(0.07 * unit) + 1;
  const cv::Rect area = cv::Rect(cv::Point(cvFloor(chin.x) - half, cvFloor(crown.y) - 2),
                                 cv::Point(cvCeil(chin.x) + half, cvCeil(chin.y) + 2)) &
                        cv::Rect({0, 0}, picture.size());
  if (area.empty()) return;
  Brush brush;
  brush.begin(area, 4);
  draw_head(brush, chin, crown, Eigen::Matrix3d::Identity(), unit, sitter);
  for (int y = area.y; y < area.br().y; ++y) {
    for (int x = area.x; x < area.br().x; ++x) {
      const auto sum = brush.pixel(x, y);
      const auto all = static_cast<float>(brush.samples_per_pixel());
      auto& to = picture.at<Colour>(y, x);
      for (int c = 0; c < 3; ++c) {
        to[c] =
            (to[c] * (all - static_cast<float>(sum[3])) + static_cast<float>(sum[static_cast<std::size_t>(c)])) / all;
      }
    }
  }
}

}  // namespace choreo::devices::synthetic
