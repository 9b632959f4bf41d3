// SPDX-License-Identifier: Apache-2.0
// Draws tapered, shaded limbs onto a finer grid than the picture's, then gives coverage and colour per pixel.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>

namespace choreo::devices::synthetic {

/// Half the thickness of a limb along its length, as a smooth curve through a few points.
class Profile {
 public:
  static constexpr int kSteps = 64;

  /// @param points  (share of the length from 0 to 1, half thickness), rising shares, at least two.
  Profile(std::initializer_list<std::pair<double, double>> points);

  [[nodiscard]] double at(double share) const;

 private:
  std::array<double, kSteps + 1> half_{};
};

/// A limb from `a` to `b` in picture coordinates (pixel edges are whole numbers).
struct Stroke {
  cv::Point2d a, b;
  const Profile* profile = nullptr;
  double scale = 1;     ///< Pixels for one unit of the profile.
  bool round_a = true;  ///< A round end; else a straight cut.
  bool round_b = true;
  cv::Vec3f colour;      ///< Blue green red, 0 to 255, in full light.
  double light = 1;      ///< Factor on the light that falls on it.
  double roundness = 1;  ///< 1 is shaded like a tube, 0 like a board.
};

/// A drawing surface over part of a picture.
class Brush {
 public:
  /// Colour at a place of a stroke: `across` from -1 to 1, `share` along the axis (below 0 and above 1 in round ends).
  using Shader = std::function<cv::Vec3f(double across, double share)>;

  /// Clears the surface and lays it over `box` with `fine` x `fine` samples a pixel.
  void begin(const cv::Rect& box, int fine);

  /// What is drawn from now on is marked with `mark`, 1 to 255; 1 after begin.
  void mark(unsigned char mark) { mark_ = mark; }

  void draw(const Stroke& stroke);
  void draw(const Stroke& stroke, const Shader& shader);
  void ellipse(cv::Point2d centre, double half_width, double half_height, cv::Vec3f colour);

  [[nodiscard]] const cv::Rect& box() const { return box_; }
  [[nodiscard]] int samples_per_pixel() const { return fine_ * fine_; }

  /// Sums over one pixel's samples: blue, green, red, and how many samples are covered.
  [[nodiscard]] std::array<int, 4> pixel(int x, int y) const;

  /// How many of a pixel's samples were drawn last under that mark.
  [[nodiscard]] int marked(int x, int y, unsigned char mark) const;

  /// Samples of row y (picture coordinates) that were drawn lie within [first, last) of picture columns.
  [[nodiscard]] std::pair<int, int> extent(int y) const;

 private:
  template <typename Colour>
  void fill(const Stroke& stroke, const Colour& colour);

  cv::Rect box_;
  int fine_ = 1;
  unsigned char mark_ = 1;
  cv::Mat4b samples_;                         // blue, green, red, mark (0: nothing drawn)
  std::vector<std::pair<int, int>> extents_;  // per row of samples, half open
};

/// Light of a round surface whose normal leans `across` (-1 to 1) towards the unit vector `side` of the picture.
[[nodiscard]] double light_on(cv::Point2d side, double across);

}  // namespace choreo::devices::synthetic
