// SPDX-License-Identifier: Apache-2.0
// How likely a tone (skin, a glove, a flag) shows a colour: Gaussians and histograms over hue, saturation and value.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <opencv2/core/matx.hpp>

#include "vision/tone_options.hpp"

namespace choreo::vision {

/// A colour in the space that every density here is over: x = s cos 2 pi h, y = s sin 2 pi h, v; the unit disc of hue
/// and saturation times [0, 1], volume pi. Unlike h itself it has no seam at red and none at grey.
/// @source Performance Physics, 5.3; h, s, v as of A. R. Smith 1978, h in turns.
struct ToneColour {
  double x = 0, y = 0, v = 0;
};

/// @param bgr  blue green red, 0 to 255, not only whole numbers. Grey and black: x = y = 0.
[[nodiscard]] ToneColour tone_colour(const cv::Vec3d& bgr);

/// What 8-bit rounding and the sensor do to x and y at a value v, as a standard deviation along either axis:
/// 1.3 sqrt(noise^2 + 1/12) / (255 v). In the dark hue and saturation are noise, and every density says so: it gets
/// wide.
/// @param noise  of a channel, grey levels.
[[nodiscard]] double tone_noise(double v, double noise);

/// The density of one tone's colours. Normalised over the plane of x and y times the line of v; what noise carries out
/// of the disc is no colour and is missed, so that the integral over the space is at most 1.
/// @thread reentrant
class ToneModel {
 public:
  virtual ~ToneModel() = default;

  /// Densities at many colours of one value, 1 / (units of x, y and v).
  virtual void densities(double v, std::span<const float> x, std::span<const float> y, std::span<float> out) const = 0;

  [[nodiscard]] double density(const ToneColour& colour) const;

 protected:
  ToneModel() = default;
  ToneModel(const ToneModel&) = default;
  ToneModel& operator=(const ToneModel&) = default;
};

/// How v bears on a tone that is modelled over x and y: a normal density, or 1 (any v) where `deviation` is 0.
struct ToneValue {
  double mean = 0;
  double deviation = 0;
};

/// How a model is made from pixels.
struct ToneFit {
  ToneKind kind = ToneKind::kGaussian;
  int parts = 1;            ///< Clusters of colours with a model each, [1, 8]: two of a two-coloured flag.
  bool with_value = true;   ///< Over x, y and v; else over x and y, with any v alike.
  double noise = 2;         ///< Of a channel, grey levels, [0, 50]: see `tone_noise`.
  double smoothing = 0.03;  ///< Histograms: deviation of the kernel in x and y, [0.005, 0.5].
};

/// A normal density with full covariance. Written as p(v) p(x, y | v), so that the noise in the dark can be added to
/// the second factor: N(v; m, c) N((x, y); m(v), C(v) + tone_noise(v)^2 I). Without noise it is the plain density with
/// its factor (2 pi)^(-d/2) |C|^(-1/2).
/// @source Performance Physics, 5.3.
class GaussianTone final : public ToneModel {
 public:
  struct Parameters {
    cv::Vec3d mean;          ///< x, y, v.
    cv::Matx33d covariance;  ///< Symmetric, positive definite; with any v alike, its third row and column are 0.
    double noise = 2;        ///< Grey levels.
    friend bool operator==(const Parameters&, const Parameters&) = default;
  };

  static constexpr std::size_t kLeastSamples = 16;

  /// @throws Error (usage) where a number is not finite or the covariance is not that of anything (not symmetric, not
  ///   positive definite, or singular), or noise is out of its range.
  explicit GaussianTone(const Parameters& parameters);

  /// Mean and covariance of pixels, the covariance with the variance of 8-bit rounding added, so that a flat colour is
  /// a narrow tone and not a singular one.
  /// @throws Error (usage) where there are fewer than `kLeastSamples`.
  [[nodiscard]] static GaussianTone fitted(std::span<const cv::Vec3b> bgr, const ToneFit& fit = {});

  void densities(double v, std::span<const float> x, std::span<const float> y, std::span<float> out) const override;
  [[nodiscard]] const Parameters& parameters() const { return parameters_; }
  [[nodiscard]] bool with_value() const { return parameters_.covariance(2, 2) > 0; }

 private:
  Parameters parameters_;
  cv::Vec2d slope_;          // Of the mean of x, y over v.
  cv::Matx22d conditional_;  // Covariance of x and y at a v, without noise.
};

/// A smoothed histogram of hue and saturation. Its cells are squares of the disc, all of one size, rather than steps of
/// h and s, of which those near grey would be slivers that noise fills at random. In the dark it is smoothed by the
/// noise, too.
class HistogramTone final : public ToneModel {
 public:
  static constexpr int kCells = 64;  ///< Along x and along y, over [-1, 1].
  static constexpr std::size_t kLeastSamples = 64;

  struct Parameters {
    std::vector<float> weights;  ///< kCells rows of y, each kCells of x: pixels, or anything in their proportion.
    ToneValue value;
    double smoothing = 0.03;
    double noise = 2;  ///< Grey levels.
    friend bool operator==(const Parameters& a, const Parameters& b) {
      return a.weights == b.weights && a.value.mean == b.value.mean && a.value.deviation == b.value.deviation &&
             a.smoothing == b.smoothing && a.noise == b.noise;
    }
  };

  /// @throws Error (usage) where there are not as many weights, or they are negative, all 0 or not finite, or another
  ///   number is out of its range.
  explicit HistogramTone(Parameters parameters);

  /// @throws Error (usage) where there are fewer than `kLeastSamples`.
  [[nodiscard]] static HistogramTone fitted(std::span<const cv::Vec3b> bgr, const ToneFit& fit = {});

  /// The cell that a place of the disc lies in: row * kCells + column.
  [[nodiscard]] static std::size_t cell_of(double x, double y);

  void densities(double v, std::span<const float> x, std::span<const float> y, std::span<float> out) const override;
  [[nodiscard]] const Parameters& parameters() const { return parameters_; }

 private:
  // The histogram smoothed ever more widely, as densities over x and y; each level's deviation in units of x.
  struct Level {
    double deviation = 0;
    std::vector<float> density;  // With a rim of one cell.
  };
  Parameters parameters_;
  std::vector<Level> levels_;
};

/// One class of colours by its name. Several parts are a mixture: the two colours of a flag.
struct Tone {
  struct Part {
    double weight = 1;  ///< > 0; divided by the sum over the parts.
    std::shared_ptr<const ToneModel> model;
  };
  std::string name;
  double prior = 0.2;  ///< > 0, over the same sum as the others' and the outliers'.
  std::vector<Part> parts;
};

/// The parts of a tone from its pixels, split where `fit.parts` is more than 1 by k-means over x, y and v from starts
/// that lie far apart, and weighted by how many pixels each has.
/// @throws Error (usage) where there are too few pixels for so many parts, or for one of them.
[[nodiscard]] std::vector<Tone::Part> fitted_parts(std::span<const cv::Vec3b> bgr, const ToneFit& fit = {});

/// Named tones beside the outliers: all that is none of them. Their density is `outlier_density`.
struct ToneSet {
  std::vector<Tone> tones;
  double outliers = 0.5;  ///< Prior of the outliers, > 0.

  /// @throws Error (usage) for a name that is empty, given twice or "outliers", a tone without parts, a prior or weight
  ///   that is not above 0.
  void validate() const;

  /// The place of a tone; `tones.size()` where there is none of that name.
  [[nodiscard]] std::size_t find(std::string_view name) const;

  [[nodiscard]] std::vector<std::string> names() const;

  /// Puts a tone in the place of that of its name, or at the end.
  void put(Tone tone);

  /// Bayes' rule: P(tone | colour) for each tone in turn, then of the outliers. They sum to 1.
  [[nodiscard]] std::vector<double> posteriors(const ToneColour& colour) const;
};

/// The density of all that is no tone: the same all over the disc, and in v for the most part, too; but three in ten
/// are dark (shadows, hair, black cloth), falling off by e every 15 grey levels. It integrates to 1 over the space.
[[nodiscard]] double outlier_density(double v);

}  // namespace choreo::vision
