// SPDX-License-Identifier: Apache-2.0
#include "devices/synthetic/room.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "devices/synthetic/chance.hpp"
#include "devices/synthetic/furniture.hpp"
#include "devices/synthetic/room_painter.hpp"

namespace choreo::devices::synthetic {
namespace {

// Smooth chance: a coarse grid of normal numbers, enlarged.
cv::Mat1f clouds(cv::Size size, double grain_px, std::uint64_t seed) {
  const int cols = static_cast<int>(std::ceil(size.width / grain_px)) + 3;
  const int rows = static_cast<int>(std::ceil(size.height / grain_px)) + 3;
  cv::Mat1f coarse(rows, cols);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < cols; ++x) {
      coarse(y, x) = static_cast<float>(
          std::clamp(normal(mixed(seed, static_cast<std::uint64_t>(y), static_cast<std::uint64_t>(x))), -2.5, 2.5));
    }
  }
  cv::Mat1f fine;
  cv::resize(coarse, fine, cv::Size(static_cast<int>(cols * grain_px) + 1, static_cast<int>(rows * grain_px) + 1), 0, 0,
             cv::INTER_CUBIC);
  return fine(cv::Rect(0, 0, size.width, size.height));
}

void paint_wall(Painter& p, double wide) {
  constexpr double kRail = 0.40;
  constexpr double kSkirting = 0.115;
  p.block(-wide, kRail, wide, 0.04, shade(p.look().panel, 1));
  // Panels with a light lower and a dark upper edge.
  constexpr double kPanel = 0.36, kGap = 0.045;
  const double line = p.thin() / p.stage().unit;
  for (double left = -kPanel / 2 - kPanel * std::ceil(wide / kPanel); left < wide; left += kPanel) {
    const double a = left + kGap / 2, b = left + kPanel - kGap / 2, top = kRail - 0.045, bottom = kSkirting + 0.035;
    p.block(a, top, b, bottom, shade(p.look().panel, 0.93));
    p.block(a + line, top - line, b, bottom, shade(p.look().panel, 1.05));
    p.block(a + line, top - line, b - line, bottom + line, shade(p.look().panel, 0.985));
  }
  p.block(-wide, kRail + 0.012, wide, kRail - 0.012, shade(p.look().panel, 1.07));
  p.block(-wide, kRail - 0.012, wide, kRail - 0.012 - line, shade(p.look().panel, 0.86));
  p.block(-wide, kSkirting, wide, 0.04, shade(p.look().panel, 1.10));
  p.block(-wide, kSkirting - 0.012, wide, kSkirting - 0.012 - line, shade(p.look().panel, 0.97));
}

void paint_floor(Painter& p, double wide) {
  auto& picture = p.picture();
  const int top = p.row(0.05);
  p.block(-wide, 0.05, wide, -2, shade(p.look().floor, 1));
  const cv::Rect below(0, top, picture.cols, std::max(0, picture.rows - top));
  if (top >= picture.rows || top < 0) return;
  cv::Mat ground = picture(below);
  // Boards run towards the viewer and spread from a point at the height of the eyes.
  for (int i = -40; i <= 40; ++i) {
    const double x = (i + 0.5) * 0.17;
    constexpr double kDepth = 2.2;  // below the wall's foot: beyond any picture's edge
    constexpr double kSpread = 1 + 1.67 * kDepth;
    cv::line(ground, {p.column(x), 0}, {p.column(x * kSpread), p.row(0.05 - kDepth) - top}, shade(p.look().floor, 0.90),
             p.thin(), cv::LINE_AA);
  }
  cv::rectangle(ground, cv::Rect(0, 0, ground.cols, p.thin()), shade(p.look().floor, 0.72), cv::FILLED);
}

void hang_picture(Painter& p, double x, double y, double width, double height, const cv::Vec3f& wood,
                  const cv::Vec3f& sky, const cv::Vec3f& land, double skyline) {
  constexpr double kWood = 0.014, kMount = 0.03;
  p.block(x - width / 2 + 0.008, y + height / 2 - 0.01, x + width / 2 + 0.008, y - height / 2 - 0.012,
          shade(p.look().wall, 0.93));
  p.block(x - width / 2, y + height / 2, x + width / 2, y - height / 2, shade(wood, 1));
  const double w = width / 2 - kWood, h = height / 2 - kWood;
  p.block(x - w, y + h, x + w, y - h, shade(cv::Vec3f(214, 222, 226), 1));
  const double iw = w - kMount, ih = h - kMount;
  p.block(x - iw, y + ih, x + iw, y - ih, shade(sky, 1));
  p.block(x - iw, y + ih * skyline, x + iw, y - ih, shade(land, 1));
  p.block(x - iw, y + ih * (skyline - 0.45), x + iw, y - ih, shade(land, 0.82));
}

}  // namespace

Stage make_stage(cv::Size size) {
  constexpr double kShareOfHeight = 0.75;
  constexpr double kRoomAside = 1.36;  // of a body stretched out and leaning, in units of its height
  constexpr double kReach = 1.25;      // jumping with the arms up
  Stage stage;
  stage.size = size;
  stage.unit = std::min(kShareOfHeight * size.height, size.width / kRoomAside);
  stage.centre_x = size.width / 2.0;
  stage.floor_y = std::min(0.95 * size.height, (size.height + kReach * stage.unit) / 2);
  return stage;
}

Stage moved_stage(const Stage& stage, double distance, double place) {
  constexpr double kFootOfWall = 0.05;  // as the room is painted, units of H above the floor under the figure
  constexpr double kKept = 1.15;        // height in units of H that stays in its row when the figure comes nearer
  Stage moved = stage;
  moved.unit = stage.unit / distance;
  moved.centre_x += place * stage.size.width;
  if (distance > 1) {
    moved.floor_y -= kFootOfWall * (stage.unit - moved.unit);
  } else {
    moved.floor_y += kKept * (moved.unit - stage.unit);
  }
  return moved;
}

Stage zoomed_stage(const Stage& stage, double zoom) {
  Stage zoomed = stage;
  zoomed.unit *= zoom;
  zoomed.centre_x = stage.size.width / 2.0 + zoom * (stage.centre_x - stage.size.width / 2.0);
  zoomed.floor_y = stage.size.height / 2.0 + zoom * (stage.floor_y - stage.size.height / 2.0);
  return zoomed;
}

cv::Mat paint_room(const Stage& stage, const Look& look, const Scene& scene, std::uint64_t seed, int margin,
                   bool anchored) {
  Painter painter(stage, margin, look);
  const double wide = stage.half_width() + margin / stage.unit + 0.1;
  paint_wall(painter, wide);
  paint_floor(painter, wide);
  const double tilt = uniform(mixed(seed, 201)) * 0.06;
  switch (scene.furniture) {
    case Furniture::kPlain:
      if (!scene.poster) {
        hang_picture(painter, -0.74, 0.86 + tilt, 0.25, 0.33, {52, 70, 92}, {196, 184, 160}, {96, 124, 112}, 0.05);
      }
      hang_picture(painter, 0.72, 0.90 - tilt, 0.27, 0.21, {46, 58, 74}, {176, 196, 206}, {128, 116, 98}, -0.1);
      break;
    case Furniture::kCluttered:
      clutter(painter, seed);
      break;
    case Furniture::kWooden:
      furnish_in_wood(painter);
      break;
  }
  if (scene.poster) hang_poster(painter);

  auto& picture = painter.picture();
  const cv::Size size = picture.size();
  // Unevenness of the plaster at three scales, and light that falls off to one side.
  const auto plaster = [&](double grain_px, std::uint64_t what) -> cv::Mat1f {
    if (!anchored) return clouds(size, grain_px, mixed(seed, what));
    cv::Mat1f wider;
    cv::copyMakeBorder(clouds(stage.size, grain_px, mixed(seed, what)), wider, margin, margin, margin, margin,
                       cv::BORDER_REFLECT);
    return wider;
  };
  const cv::Mat1f coarse = plaster(std::max(2.0, stage.unit * 0.16), 211);
  const cv::Mat1f middle = plaster(std::max(1.0, stage.unit * 0.045), 212);
  const cv::Mat1f small = plaster(std::max(1.0, stage.unit * 0.010), 213);
  cv::Mat out(size, CV_16SC3);
  constexpr float kLevelScale = 1 << kLevelBits;
  for (int y = 0; y < size.height; ++y) {
    const auto* from = picture.ptr<cv::Vec3f>(y);
    auto* to = out.ptr<cv::Vec3s>(y);
    const double v = (y - margin) / static_cast<double>(stage.size.height);
    for (int x = 0; x < size.width; ++x) {
      const double u = (x - margin) / static_cast<double>(stage.size.width);
      const double light = 1.05 - 0.07 * u - 0.05 * v * v;
      const float texture = 1.6F * coarse(y, x) + 1.3F * middle(y, x) + 0.9F * small(y, x);
      for (int c = 0; c < 3; ++c) {
        const float level = static_cast<float>(from[x][c] * light) + texture;
        to[x][c] = static_cast<short>(cvRound(std::clamp(level, 0.0F, 255.0F) * kLevelScale));
      }
    }
  }
  return out;
}

}  // namespace choreo::devices::synthetic
