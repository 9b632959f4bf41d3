// SPDX-License-Identifier: Apache-2.0
#include "confidence_plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numbers>

#include <fmt/format.h>

#include "core/error.hpp"
#include "outputs/plot_canvas.hpp"

namespace choreo::bench {
namespace {

using outputs::Anchor;
using outputs::Canvas;
using outputs::Point;
using outputs::Rgb;

constexpr std::array<std::pair<double, double>, 6> kBins = {
    {{0, 0.5}, {0.5, 0.7}, {0.7, 0.8}, {0.8, 0.9}, {0.9, 0.95}, {0.95, 1}}};

constexpr int kColumns = 3, kPanel = 250, kLeft = 58, kTop = 46, kRight = 20, kBottom = 58;
constexpr Rgb kInk{0.13, 0.13, 0.15}, kQuiet{0.45, 0.45, 0.48}, kHair{0.86, 0.86, 0.88}, kDot{0.05, 0.36, 0.65};

// Of Wilson, 95 of 100.
std::pair<double, double> interval(double right, double count) {
  constexpr double z = 1.96;
  const double share = right / count, middle = (share + z * z / 2 / count) / (1 + z * z / count);
  const double half = z / (1 + z * z / count) * std::sqrt(share * (1 - share) / count + z * z / 4 / count / count);
  return {middle - half, middle + half};
}

void disc(Canvas& canvas, Point at, double radius) {
  // A fat closed outline of half the radius.
  std::vector<Point> ring;
  for (int k = 0; k < 24; ++k) {
    const double angle = 2 * std::numbers::pi * k / 24;
    ring.push_back({at.x + radius / 2 * std::cos(angle), at.y + radius / 2 * std::sin(angle)});
  }
  canvas.stroke(ring, true, radius, kDot);
}

void panel(Canvas& canvas, const NamedAnswers& one, Point corner) {
  const auto place = [&](double told, double share) {
    return Point{corner.x + told * kPanel, corner.y + (1 - share) * kPanel};
  };
  const auto line = [&](Point a, Point b, double width, Rgb colour) {
    canvas.stroke(std::array{a, b}, false, width, colour);
  };
  for (const double tick : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    line(place(tick, 0), place(tick, 1), 1, kHair);
    line(place(0, tick), place(1, tick), 1, kHair);
    const auto name = fmt::format("{:g}", tick);
    canvas.text({place(tick, 0).x, place(tick, 0).y + 18}, name, {12, kQuiet, Anchor::kMiddle});
    canvas.text({corner.x - 8, place(0, tick).y + 4}, name, {12, kQuiet, Anchor::kEnd});
  }
  line(place(0, 0), place(1, 1), 1, kQuiet);
  for (const auto& [from, to] : kBins) {
    double told = 0, right = 0, count = 0;
    for (const auto& answer : one.answers) {
      if (answer.confidence <= from || answer.confidence > to) continue;
      told += answer.confidence;
      right += answer.right ? 1 : 0;
      ++count;
    }
    if (count == 0) continue;
    const auto [low, high] = interval(right, count);
    line(place(told / count, low), place(told / count, high), 1.5, kDot);
    disc(canvas, place(told / count, right / count), 2.5 + 1.2 * std::log2(1 + count));
  }
  canvas.text({corner.x, corner.y - 14}, one.name, {15, kInk, Anchor::kStart, true});
  canvas.text({corner.x + kPanel, corner.y - 14}, fmt::format("{} answers", one.answers.size()),
              {12, kQuiet, Anchor::kEnd});
}

void draw(Canvas& canvas, const std::vector<NamedAnswers>& all, int width, int height) {
  canvas.fill({0, 0, double(width), double(height)}, {1, 1, 1});
  for (std::size_t k = 0; k < all.size(); ++k) {
    const auto column = double(k % kColumns), row = double(k / kColumns);
    const Point corner{kLeft + column * (kPanel + kLeft + kRight), kTop + row * (kPanel + kTop + kBottom)};
    panel(canvas, all[k], corner);
    if (k % kColumns == 0) {
      canvas.text({corner.x - 42, corner.y + kPanel / 2.0}, "share that is right",
                  {13, kInk, Anchor::kMiddle, false, true});
    }
    canvas.text({corner.x + kPanel / 2.0, corner.y + kPanel + 40}, "confidence that is told",
                {13, kInk, Anchor::kMiddle});
  }
}

}  // namespace

std::span<const std::pair<double, double>> confidence_bins() { return kBins; }

void plot_confidence(const std::vector<NamedAnswers>& all, const std::string& path) {
  const int rows = (int(all.size()) + kColumns - 1) / kColumns;
  const int width = kColumns * (kPanel + kLeft + kRight), height = rows * (kPanel + kTop + kBottom);
  outputs::PixelCanvas canvas(width, height);
  draw(canvas, all, width, height);
  std::ofstream file(path, std::ios::binary);
  file << canvas.png();
  file.close();
  if (!file) throw failure(fmt::format("\"{}\" cannot be written", path), "--plot");
}

}  // namespace choreo::bench
