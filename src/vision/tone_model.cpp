// SPDX-License-Identifier: Apache-2.0
#include "vision/tone_model.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "core/error.hpp"
#include "vision/fast_exp.hpp"

namespace choreo::vision {
namespace {

constexpr double kRounding = 1.0 / 12.0;  // Variance of rounding to whole grey levels.
// s loses from noise in the least and in the greatest channel, 2 pi s h from that in all three.
constexpr double kNoiseOfRatio = 1.3;
constexpr double kMostNoise = 50;

void check_noise(double noise) {
  if (noise >= 0 && noise <= kMostNoise) return;
  throw usage_error(fmt::format("the noise of a tone is {}", noise), {},
                    fmt::format("it is from 0 to {} grey levels", kMostNoise));
}

[[nodiscard]] double normal(double v, double mean, double variance) {
  const double d = v - mean;
  return std::exp(-0.5 * d * d / variance) / std::sqrt(2 * std::numbers::pi * variance);
}

void check_samples(std::size_t count, std::size_t least, const std::string& whose = "a tone") {
  if (count >= least) return;
  throw usage_error(fmt::format("too few pixels for {}: {}", whose, count), {}, fmt::format("give at least {}", least));
}

}  // namespace

ToneColour tone_colour(const cv::Vec3d& bgr) {
  const double b = bgr[0];
  const double g = bgr[1];
  const double r = bgr[2];
  const double most = std::max({b, g, r});
  const double range = most - std::min({b, g, r});
  ToneColour out{0, 0, most / 255};
  if (range <= 0) return out;
  double sixths = 0;  // Hue.
  if (most == r) {
    sixths = (g - b) / range;
  } else if (most == g) {
    sixths = 2 + (b - r) / range;
  } else {
    sixths = 4 + (r - g) / range;
  }
  const double angle = sixths * std::numbers::pi / 3;
  out.x = range / most * std::cos(angle);
  out.y = range / most * std::sin(angle);
  return out;
}

double tone_noise(double v, double noise) {
  // Below one grey level there is none to tell anything.
  return kNoiseOfRatio * std::sqrt(noise * noise + kRounding) / std::max(255 * v, 1.0);
}

double outlier_density(double v) {
  constexpr double kDark = 0.3;
  constexpr double kFades = 15.0 / 255;
  return (1 - kDark + kDark / kFades * std::exp(-v / kFades)) / std::numbers::pi;
}

double ToneModel::density(const ToneColour& colour) const {
  const auto x = static_cast<float>(colour.x);
  const auto y = static_cast<float>(colour.y);
  float out = 0;
  densities(colour.v, {&x, 1}, {&y, 1}, {&out, 1});
  return out;
}

GaussianTone::GaussianTone(const Parameters& parameters) : parameters_(parameters) {
  const auto& c = parameters_.covariance;
  check_noise(parameters_.noise);
  const auto sane = [](double number) { return std::abs(number) <= 10; };  // Which no NaN is.
  const bool finite =
      std::all_of(parameters_.mean.val, parameters_.mean.val + 3, sane) && std::all_of(c.val, c.val + 9, sane);
  if (!finite) throw usage_error("a tone's mean or covariance is no number, or larger than any colour's");
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < i; ++j) {
      if (std::abs(c(i, j) - c(j, i)) > 1e-9) throw usage_error("a tone's covariance is not symmetric");
    }
  }
  // Its own part of x and y at a given v, and v itself, must each have some extent: below that of rounding lies
  // nothing.
  constexpr double kLeast = 1e-8;
  conditional_ = {c(0, 0), c(0, 1), c(1, 0), c(1, 1)};
  if (with_value()) {
    slope_ = {c(0, 2) / c(2, 2), c(1, 2) / c(2, 2)};
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) conditional_(i, j) -= c(i, 2) * c(j, 2) / c(2, 2);
    }
  } else if (c(0, 2) != 0 || c(1, 2) != 0 || c(2, 2) < 0) {
    throw usage_error("a tone's covariance is not positive definite");
  }
  const double trace = cv::trace(conditional_);
  const double determinant = cv::determinant(conditional_);
  if (trace <= 0 || determinant < 0) throw usage_error("a tone's covariance is not positive definite");
  // The lesser eigenvalue.
  if (determinant / trace < kLeast || (with_value() && c(2, 2) < kLeast)) {
    throw usage_error("a tone's covariance is singular", {},
                      "train it on pixels that are not all of one line of colours");
  }
}

GaussianTone GaussianTone::fitted(std::span<const cv::Vec3b> bgr, const ToneFit& fit) {
  check_samples(bgr.size(), GaussianTone::kLeastSamples);
  cv::Vec3d sum;
  cv::Matx33d squares = cv::Matx33d::zeros();
  double rounding = 0;
  for (const auto& pixel : bgr) {
    const auto c = tone_colour(pixel);
    const cv::Vec3d at(c.x, c.y, c.v);
    sum += at;
    squares += at * at.t();
    const double noise = tone_noise(c.v, 0);
    rounding += noise * noise;
  }
  const double scale = 1.0 / double(bgr.size());
  Parameters out;
  out.noise = fit.noise;
  out.mean = sum * scale;
  out.covariance = squares * scale - out.mean * out.mean.t();
  out.covariance(0, 0) += rounding * scale;
  out.covariance(1, 1) += rounding * scale;
  out.covariance(2, 2) += kRounding / (255.0 * 255.0);
  if (!fit.with_value) {
    out.mean[2] = 0;
    for (int i = 0; i < 3; ++i) out.covariance(i, 2) = out.covariance(2, i) = 0;
  }
  return GaussianTone(out);
}

void GaussianTone::densities(double v, std::span<const float> x, std::span<const float> y, std::span<float> out) const {
  assert(x.size() == y.size() && x.size() == out.size());
  const auto& m = parameters_.mean;
  const double away = with_value() ? v - m[2] : 0;
  const double noise = tone_noise(v, parameters_.noise);
  const double xx = conditional_(0, 0) + noise * noise;
  const double yy = conditional_(1, 1) + noise * noise;
  const double xy = conditional_(0, 1);
  const double determinant = xx * yy - xy * xy;
  const double factor = (with_value() ? normal(v, m[2], parameters_.covariance(2, 2)) : 1.0) /
                        (2 * std::numbers::pi * std::sqrt(determinant));
  const auto mx = static_cast<float>(m[0] + slope_[0] * away);
  const auto my = static_cast<float>(m[1] + slope_[1] * away);
  const auto pxx = static_cast<float>(-0.5 * yy / determinant);
  const auto pyy = static_cast<float>(-0.5 * xx / determinant);
  const auto pxy = static_cast<float>(xy / determinant);
  const auto peak = static_cast<float>(factor);
  // Most colours are far from any one tone: where a whole block is, no power is taken.
  constexpr std::size_t kBlock = 64;
  constexpr float kFar = -20.0F;  // Less than single precision sees beside the outliers.
  std::array<float, kBlock> exponent;
  for (std::size_t begin = 0; begin < out.size(); begin += kBlock) {
    const auto count = std::min(kBlock, out.size() - begin);
    int near = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const float dx = x[begin + i] - mx;
      const float dy = y[begin + i] - my;
      exponent[i] = pxx * dx * dx + pyy * dy * dy + pxy * dx * dy;
      near |= int(exponent[i] >= kFar);
    }
    if (near == 0) {
      std::fill_n(out.data() + begin, count, 0.0F);
      continue;
    }
    for (std::size_t i = 0; i < count; ++i) {
      const float density = peak * fast_exp(exponent[i]);
      out[begin + i] = exponent[i] < kFar ? 0.0F : density;
    }
  }
}

namespace {

// Smooths a histogram by a normal kernel along both axes; what leaves the square is lost, as what leaves the disc.
std::vector<float> smoothed(const std::vector<float>& shares, double deviation) {
  constexpr int kCells = HistogramTone::kCells;
  const int reach = std::min(kCells, static_cast<int>(std::ceil(4 * deviation)) + 1);
  // The kernel's share of each cell, by integration: exact where it is narrower than a cell.
  std::vector<double> kernel(std::size_t(2 * reach + 1));
  for (int k = -reach; k <= reach; ++k) {
    const auto below = [&](double edge) { return 0.5 * std::erfc(-edge / (deviation * std::numbers::sqrt2)); };
    kernel[std::size_t(k + reach)] = below(k + 0.5) - below(k - 0.5);
  }
  const auto along = [&](const std::vector<float>& in, int step, int across) {
    std::vector<float> out(in.size(), 0.0F);
    for (int line = 0; line < kCells; ++line) {
      for (int i = 0; i < kCells; ++i) {
        const float share = in[std::size_t(line * across + i * step)];
        if (share == 0) continue;
        for (int k = std::max(0, i - reach); k <= std::min(kCells - 1, i + reach); ++k) {
          out[std::size_t(line * across + k * step)] += static_cast<float>(share * kernel[std::size_t(k - i + reach)]);
        }
      }
    }
    return out;
  };
  return along(along(shares, 1, kCells), kCells, 1);
}

}  // namespace

HistogramTone::HistogramTone(Parameters parameters) : parameters_(std::move(parameters)) {
  auto& p = parameters_;
  check_noise(p.noise);
  if (!(p.smoothing >= 0.005 && p.smoothing <= 0.5)) {
    throw usage_error(fmt::format("the smoothing of a tone's histogram is {}", p.smoothing), {},
                      "it is from 0.005 to 0.5");
  }
  if (!(p.value.deviation >= 0 && p.value.deviation <= 10) || !(std::abs(p.value.mean) <= 10)) {
    throw usage_error("a tone's mean or deviation of v is no number, or larger than any colour's");
  }
  if (p.weights.size() != std::size_t(kCells) * kCells) {
    throw usage_error(fmt::format("a tone's histogram has {} cells", p.weights.size()), {},
                      fmt::format("it has {} x {}", kCells, kCells));
  }
  double sum = 0;
  for (const float weight : p.weights) {
    if (!(weight >= 0 && weight < 1e12F))
      throw usage_error("a tone's histogram holds a weight that is negative or no number");
    sum += weight;
  }
  if (sum <= 0) throw usage_error("a tone's histogram is empty");
  std::vector<float> shares;
  for (const float weight : p.weights) shares.push_back(static_cast<float>(weight / sum));

  // Up to where noise fills the whole disc; in between, two neighbours are mixed.
  constexpr double kUnit = 2.0 / kCells;
  for (double deviation = p.smoothing;; deviation *= 1.6) {
    Level level{deviation, std::vector<float>(std::size_t(kCells + 2) * (kCells + 2), 0.0F)};
    // Sorting into cells and interpolating between them have smoothed, too: by a twelfth and a sixth of a cell's
    // square.
    const double kernel = std::sqrt(std::max(deviation * deviation - kUnit * kUnit / 4, kUnit * kUnit / 64));
    const auto wider = smoothed(shares, kernel / kUnit);
    for (int y = 0; y < kCells; ++y) {
      for (int x = 0; x < kCells; ++x) {
        level.density[std::size_t((y + 1) * (kCells + 2) + x + 1)] =
            wider[std::size_t(y * kCells + x)] / static_cast<float>(kUnit * kUnit);
      }
    }
    levels_.push_back(std::move(level));
    if (deviation > 1) break;
  }
}

HistogramTone HistogramTone::fitted(std::span<const cv::Vec3b> bgr, const ToneFit& fit) {
  check_samples(bgr.size(), HistogramTone::kLeastSamples);
  Parameters out;
  out.weights.assign(std::size_t(kCells) * kCells, 0.0F);
  out.noise = fit.noise;
  out.smoothing = fit.smoothing;
  double sum = 0;
  double squares = 0;
  for (const auto& pixel : bgr) {
    const auto c = tone_colour(pixel);
    out.weights[cell_of(c.x, c.y)] += 1;
    sum += c.v;
    squares += c.v * c.v;
  }
  if (fit.with_value) {
    const auto n = double(bgr.size());
    out.value = {sum / n, std::sqrt(std::max(0.0, squares / n - sum * sum / (n * n)) + kRounding / (255.0 * 255.0))};
  }
  return HistogramTone(std::move(out));
}

std::size_t HistogramTone::cell_of(double x, double y) {
  const auto along = [](double at) { return std::clamp(static_cast<int>((at + 1) * kCells / 2), 0, kCells - 1); };
  return std::size_t(along(y) * kCells + along(x));
}

void HistogramTone::densities(double v, std::span<const float> x, std::span<const float> y,
                              std::span<float> out) const {
  assert(x.size() == y.size() && x.size() == out.size());
  const auto& value = parameters_.value;
  const double of_v = value.deviation > 0 ? normal(v, value.mean, value.deviation * value.deviation) : 1.0;
  const double wanted =
      std::min(std::hypot(parameters_.smoothing, tone_noise(v, parameters_.noise)), levels_.back().deviation);
  std::size_t above = 1;
  while (above + 1 < levels_.size() && levels_[above].deviation < wanted) ++above;
  const auto& narrow = levels_[above - 1];
  const auto& wide = levels_[above];
  const double share = (wanted - narrow.deviation) / (wide.deviation - narrow.deviation);
  const auto of_wide = static_cast<float>(of_v * share);
  const auto of_narrow = static_cast<float>(of_v * (1 - share));
  constexpr float kPerUnit = kCells / 2.0F;
  for (std::size_t i = 0; i < out.size(); ++i) {
    // Between the centres of four cells; the rim is 0.
    const float column = std::clamp((x[i] + 1) * kPerUnit + 0.5F, 0.0F, kCells + 0.999F);
    const float row = std::clamp((y[i] + 1) * kPerUnit + 0.5F, 0.0F, kCells + 0.999F);
    const auto c = static_cast<std::size_t>(column);
    const auto r = static_cast<std::size_t>(row);
    const float fc = column - static_cast<float>(c);
    const float fr = row - static_cast<float>(r);
    const auto between = [&](const std::vector<float>& d) {
      const auto* at = d.data() + r * (kCells + 2) + c;
      return (at[0] * (1 - fc) + at[1] * fc) * (1 - fr) + (at[kCells + 2] * (1 - fc) + at[kCells + 3] * fc) * fr;
    };
    out[i] = of_narrow * between(narrow.density) + of_wide * between(wide.density);
  }
}

namespace {

struct Clusters {
  std::vector<std::size_t> of;  // By point.
  double spread = 0;            // Sum of the squared distances from the centres.
};

// Twenty rounds of k-means. Each start is the point that is farther from those before it, the first from the mean, than
// that share of the points: no lots, the same every time.
Clusters clustered(const std::vector<cv::Vec3d>& at, std::size_t count, double share) {
  cv::Vec3d mean;
  for (const auto& p : at) mean += p * (1.0 / double(at.size()));
  std::vector<cv::Vec3d> centres;
  std::vector<double> nearest(at.size());
  for (std::size_t i = 0; i < at.size(); ++i) nearest[i] = cv::norm(at[i] - mean);
  std::vector<std::size_t> order(at.size());
  const auto rank = static_cast<std::ptrdiff_t>(share * double(at.size() - 1));
  while (centres.size() < count) {
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::nth_element(order.begin(), order.begin() + rank, order.end(), [&](std::size_t a, std::size_t b) {
      return nearest[a] < nearest[b] || (nearest[a] == nearest[b] && a > b);
    });
    centres.push_back(at[order[std::size_t(rank)]]);
    for (std::size_t i = 0; i < at.size(); ++i) {
      const double distance = cv::norm(at[i] - centres.back());
      nearest[i] = centres.size() == 1 ? distance : std::min(nearest[i], distance);
    }
  }
  Clusters clusters;
  clusters.of.resize(at.size());
  for (int round = 0; round < 20; ++round) {
    std::vector<cv::Vec3d> sums(count);
    std::vector<double> sizes(count);
    clusters.spread = 0;
    for (std::size_t i = 0; i < at.size(); ++i) {
      std::size_t best = 0;
      double least = cv::norm(at[i] - centres[0]);
      for (std::size_t k = 1; k < count; ++k) {
        const double distance = cv::norm(at[i] - centres[k]);
        if (distance < least) {
          best = k;
          least = distance;
        }
      }
      clusters.of[i] = best;
      clusters.spread += least * least;
      sums[best] += at[i];
      sizes[best] += 1;
    }
    for (std::size_t k = 0; k < count; ++k) {
      if (sizes[k] > 0) centres[k] = sums[k] * (1.0 / sizes[k]);
    }
  }
  return clusters;
}

}  // namespace

std::vector<Tone::Part> fitted_parts(std::span<const cv::Vec3b> bgr, const ToneFit& fit) {
  if (fit.parts < 1 || fit.parts > 8) {
    throw usage_error(fmt::format("{} parts for a tone", fit.parts), {}, "it has from 1 to 8");
  }
  const auto made = [&](std::span<const cv::Vec3b> pixels) -> std::shared_ptr<const ToneModel> {
    if (fit.kind == ToneKind::kHistogram) return std::make_shared<HistogramTone>(HistogramTone::fitted(pixels, fit));
    return std::make_shared<GaussianTone>(GaussianTone::fitted(pixels, fit));
  };
  if (fit.parts == 1) return {{1, made(bgr)}};

  const auto count = static_cast<std::size_t>(fit.parts);
  const auto least = fit.kind == ToneKind::kHistogram ? HistogramTone::kLeastSamples : GaussianTone::kLeastSamples;
  check_samples(bgr.size(), count * least, fmt::format("a tone of {} parts", count));
  std::vector<cv::Vec3d> at;
  for (const auto& pixel : bgr) {
    const auto c = tone_colour(pixel);
    at.emplace_back(c.x, c.y, c.v);
  }
  // The farthest pixels may be a stick that was painted with its flag: the closest clusters of several starts count.
  Clusters best;
  for (const double share : {1.0, 0.98, 0.9}) {
    auto clusters = clustered(at, count, share);
    if (best.of.empty() || clusters.spread < best.spread) best = std::move(clusters);
  }
  std::vector<std::vector<cv::Vec3b>> pixels(count);
  for (std::size_t i = 0; i < bgr.size(); ++i) pixels[best.of[i]].push_back(bgr[i]);
  for (std::size_t k = 0; k < count; ++k) {
    if (pixels[k].size() >= least) continue;
    throw usage_error(
        fmt::format("part {} of {} is of {} of the {} pixels", k + 1, count, pixels[k].size(), bgr.size()), {},
        fmt::format("a part has at least {}: the colours fall into fewer parts, so ask for fewer", least));
  }
  std::vector<Tone::Part> parts;
  for (const auto& part : pixels) parts.push_back({double(part.size()) / double(bgr.size()), made(part)});
  return parts;
}

void ToneSet::validate() const {
  const auto refuse = [](const std::string& what, const std::string& hint) { throw usage_error(what, {}, hint); };
  if (!(outliers > 0 && std::isfinite(outliers))) {
    refuse(fmt::format("the prior of the outliers is {}", outliers), "it is above 0");
  }
  for (std::size_t i = 0; i < tones.size(); ++i) {
    const auto& tone = tones[i];
    if (tone.name.empty()) refuse("a tone has no name", "call it after what shows it, such as glove");
    if (tone.name == "outliers") refuse("a tone is called \"outliers\"", "that is what is none of the tones");
    if (find(tone.name) != i)
      refuse(fmt::format("tone \"{}\" is there twice", tone.name), "merge them as two parts of one");
    if (!(tone.prior > 0 && std::isfinite(tone.prior))) {
      refuse(fmt::format("the prior of tone \"{}\" is {}", tone.name, tone.prior), "it is above 0");
    }
    if (tone.parts.empty()) refuse(fmt::format("tone \"{}\" has no model", tone.name), "train it");
    for (const auto& part : tone.parts) {
      assert(part.model);
      if (part.weight > 0 && std::isfinite(part.weight)) continue;
      refuse(fmt::format("a part of tone \"{}\" has the weight {}", tone.name, part.weight), "it is above 0");
    }
  }
}

std::size_t ToneSet::find(std::string_view name) const {
  const auto at = std::find_if(tones.begin(), tones.end(), [&](const Tone& tone) { return tone.name == name; });
  return static_cast<std::size_t>(at - tones.begin());
}

std::vector<std::string> ToneSet::names() const {
  std::vector<std::string> all;
  for (const auto& tone : tones) all.push_back(tone.name);
  return all;
}

void ToneSet::put(Tone tone) {
  const auto at = find(tone.name);
  if (at == tones.size()) {
    tones.push_back(std::move(tone));
  } else {
    tones[at] = std::move(tone);
  }
}

std::vector<double> ToneSet::posteriors(const ToneColour& colour) const {
  std::vector<double> out;
  double sum = outliers * outlier_density(colour.v);
  for (const auto& tone : tones) {
    double density = 0;
    double weights = 0;
    for (const auto& part : tone.parts) {
      density += part.weight * part.model->density(colour);
      weights += part.weight;
    }
    out.push_back(tone.prior * density / weights);
    sum += out.back();
  }
  out.push_back(outliers * outlier_density(colour.v));
  for (auto& p : out) p /= sum;
  return out;
}

}  // namespace choreo::vision
