// SPDX-License-Identifier: Apache-2.0
// What a figure is drawn with: lines, pictures and type, onto pixels (Cairo, Pango) or into an SVG, from one drawing.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include <opencv2/core/mat.hpp>

namespace choreo::outputs {

struct Point {
  double x = 0.0;
  double y = 0.0;
};

struct Box {
  double x = 0.0;
  double y = 0.0;
  double width = 0.0;
  double height = 0.0;
};

struct Rgb {
  double r = 0.0;  ///< 0 to 1, as in sRGB.
  double g = 0.0;
  double b = 0.0;
};

enum class Anchor { kStart, kMiddle, kEnd };

struct TextStyle {
  double size = 16.0;  ///< Pixels an em.
  Rgb color;
  Anchor anchor = Anchor::kStart;
  bool bold = false;
  bool upwards = false;  ///< Turned by a quarter, read from below.
};

/// How a picture is enlarged: cells stay cells, or a photograph stays smooth.
enum class Scaling { kCrisp, kSmooth };

/// Where a figure goes. Coordinates are pixels, x to the right, y downwards; a later shape covers an earlier one.
class Canvas {
 public:
  virtual ~Canvas() = default;
  virtual void fill(const Box& box, Rgb color) = 0;
  /// An open or closed outline.
  virtual void stroke(std::span<const Point> points, bool closed, double width, Rgb color) = 0;
  /// @param picture  8-bit BGR, or BGRA with straight alpha; fills the box.
  /// @param clip     a polygon outside of which nothing is drawn; empty: the whole box.
  virtual void image(const cv::Mat& picture, const Box& box, Scaling scaling, std::span<const Point> clip = {}) = 0;
  /// @param at    where the anchor of the base line is.
  /// @param text  valid UTF-8, one line.
  virtual void text(Point at, std::string_view text, const TextStyle& style) = 0;
};

/// How wide a line of type is, in pixels. Thread: one at a time.
class TextMeter {
 public:
  TextMeter();
  ~TextMeter();
  TextMeter(const TextMeter&) = delete;
  TextMeter& operator=(const TextMeter&) = delete;
  [[nodiscard]] double width(std::string_view text, double size, bool bold = false) const;
  /// The text itself where it fits, else its beginning and end around "...".
  [[nodiscard]] std::string shortened(std::string_view text, double size, bool bold, double most_px) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A canvas of pixels.
class PixelCanvas final : public Canvas {
 public:
  /// @param width, height  1 to 32767 pixels. Error (failure) where there is no memory for them.
  PixelCanvas(int width, int height);
  ~PixelCanvas() override;
  void fill(const Box& box, Rgb color) override;
  void stroke(std::span<const Point> points, bool closed, double width, Rgb color) override;
  void image(const cv::Mat& picture, const Box& box, Scaling scaling, std::span<const Point> clip) override;
  void text(Point at, std::string_view text, const TextStyle& style) override;

  [[nodiscard]] cv::Mat bgr() const;
  /// The bytes of a PNG file; the same for the same drawing.
  [[nodiscard]] std::string png() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A canvas that becomes SVG 1.1: type stays type, pictures are embedded as PNG.
class SvgCanvas final : public Canvas {
 public:
  SvgCanvas(int width, int height);
  void fill(const Box& box, Rgb color) override;
  void stroke(std::span<const Point> points, bool closed, double width, Rgb color) override;
  void image(const cv::Mat& picture, const Box& box, Scaling scaling, std::span<const Point> clip) override;
  void text(Point at, std::string_view text, const TextStyle& style) override;

  /// The whole document.
  [[nodiscard]] std::string svg() const;

 private:
  std::string body_;
  int clips_ = 0;
};

/// Valid UTF-8 on one line: control characters become spaces, broken bytes the replacement character.
[[nodiscard]] std::string printable(std::string_view text);

}  // namespace choreo::outputs
