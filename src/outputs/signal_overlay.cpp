// SPDX-License-Identifier: Apache-2.0
#include "outputs/signal_overlay.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "outputs/plot_canvas.hpp"

namespace choreo::outputs {
namespace {

constexpr Rgb kLetter{1.0, 0.86, 0.20};
constexpr Rgb kText{0.96, 0.96, 0.95};
constexpr double kPlate = 0.38;         // What is left of the picture's light behind type.
constexpr double kLetterHeight = 0.30;  // Of the picture's height, an em.
constexpr double kSmallHeight = 0.045;
constexpr double kTextHeight = 0.065;
constexpr double kWidest = 0.27;  // Of the picture's width: what is longer would cover who stands in the middle.
constexpr double kWidestBeside = 0.5;

void darken(cv::Mat& picture, const Box& box) {
  const cv::Rect at(static_cast<int>(box.x), static_cast<int>(box.y), static_cast<int>(std::ceil(box.width)),
                    static_cast<int>(std::ceil(box.height)));
  auto part = picture(at & cv::Rect({}, picture.size()));
  if (!part.empty()) part.convertTo(part, -1, kPlate);
}

void draw(Canvas& canvas, const Ring& ring, double width, Rgb colour) {
  constexpr int kCorners = 48;
  const double turn = ring.angle_deg * std::numbers::pi / 180;
  std::vector<Point> points;
  for (int k = 0; k < kCorners; ++k) {
    const double angle = 2 * std::numbers::pi * k / kCorners;
    const double a = ring.half.width * std::cos(angle);
    const double b = ring.half.height * std::sin(angle);
    points.push_back({ring.centre.x + a * std::cos(turn) - b * std::sin(turn),
                      ring.centre.y + a * std::sin(turn) + b * std::cos(turn)});
  }
  canvas.stroke(points, true, width, colour);
}

// As much of the end of a text as fits.
std::string ending(const TextMeter& meter, std::string text, double size, double room) {
  while (!text.empty() && meter.width(text, size, true) > room) {
    std::size_t next = 1;  // Whole characters.
    while (next < text.size() && (static_cast<unsigned char>(text[next]) & 0xC0U) == 0x80U) ++next;
    text.erase(0, next);
  }
  return text;
}

}  // namespace

Ring ring_of(cv::Point2d centroid, double cov_xx, double cov_xy, double cov_yy) {
  const double mean = (cov_xx + cov_yy) / 2;
  const double apart = std::hypot((cov_xx - cov_yy) / 2, cov_xy);
  const double angle = std::atan2(2 * cov_xy, cov_xx - cov_yy) / 2;
  // Of a full ellipse the second moment along an axis is a quarter of its half axis squared.
  return {centroid,
          {2 * std::sqrt(std::max(0.0, mean + apart)), 2 * std::sqrt(std::max(0.0, mean - apart))},
          angle * 180 / std::numbers::pi};
}

cv::Mat drawn_over(const cv::Mat& picture, const SignalOverlay& overlay) {
  const double width = picture.cols;
  const double height = picture.rows;
  const TextMeter meter;
  const double small = std::max(7.0, kSmallHeight * height);
  const double text_size = std::max(8.0, kTextHeight * height);
  const double margin = 0.4 * small;
  const auto letter = printable(overlay.letter);
  const auto beside = meter.shortened(printable(overlay.beside), small, false, kWidestBeside * width);
  const auto text = ending(meter, printable(overlay.text), text_size, width - 4 * margin);

  double letter_size = kLetterHeight * height;
  const double natural = meter.width(letter, letter_size, true);
  if (natural > kWidest * width) letter_size *= kWidest * width / natural;
  const double strip = text.empty() ? 0 : 1.5 * text_size;
  // Capitals are 0.73 em high.
  const double capital = letter.empty() ? 0 : 0.73 * letter_size;
  const double line = beside.empty() ? 0 : 1.5 * small;
  const Box plate{margin, height - strip - margin - capital - line - 2 * margin,
                  std::max(meter.width(letter, letter_size, true), meter.width(beside, small)) + 4 * margin,
                  capital + line + 2 * margin};
  const bool plated = !letter.empty() || !beside.empty();

  cv::Mat under = picture.clone();
  if (plated) darken(under, plate);
  if (!text.empty()) darken(under, {0, height - strip, width, strip});
  PixelCanvas canvas(picture.cols, picture.rows);
  canvas.image(under, {0, 0, width, height}, Scaling::kCrisp, {});
  const double pen = std::max(1.0, height / 240);
  for (const auto& ring : overlay.faces) draw(canvas, ring, pen, kText);
  for (const auto& ring : overlay.arms) draw(canvas, ring, 1.5 * pen, kLetter);
  const double left = plate.x + 2 * margin;
  if (!beside.empty()) canvas.text({left, plate.y + margin + small}, beside, {.size = small, .color = kText});
  if (!letter.empty()) {
    canvas.text({left, plate.y + plate.height - margin}, letter, {.size = letter_size, .color = kLetter, .bold = true});
  }
  if (!text.empty()) {
    canvas.text({2 * margin, height - strip + 1.1 * text_size}, text,
                {.size = text_size, .color = kText, .bold = true});
  }
  return canvas.bgr();
}

}  // namespace choreo::outputs
