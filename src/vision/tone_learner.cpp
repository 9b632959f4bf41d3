// SPDX-License-Identifier: Apache-2.0
#include "vision/tone_learner.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

#include <opencv2/core.hpp>  // Matx::inv

namespace choreo::vision {
namespace {

constexpr std::size_t kLeastPixels = 6;  // Of one face: fewer are no face's tone.
constexpr double kLeastGathered = 60;
constexpr double kMostUnseen_s = 0.5;
constexpr double kUnlike_s = 2.0;
constexpr double kMostLookStep_s = 0.2;  // What one look can add to a time of looks, after a gap.

// How much wider the arms' tone is than the face's, chosen on synthetic performers of all skins and on a real
// recording.
constexpr double kAlongSaturation = 0.16;  // Shares of the saturation.
constexpr double kAcrossSaturation = 0.10;
constexpr double kEverywhere = 0.02;
constexpr double kValueShare = 0.95;     // Mean of v, of the face's.
constexpr double kValueDeviation = 0.2;  // Its deviation, of the face's v.
constexpr double kClothesValueShare = 0.95;
constexpr double kClothesPrior = 0.3;
constexpr double kLeastApart = 1.5;  // Deviations.

cv::Rect cut(double x0, double y0, double x1, double y1, cv::Size size) {
  const cv::Rect2d box(x0, y0, x1 - x0, y1 - y0);
  const cv::Point a(cvRound(std::clamp(box.x, 0.0, double(size.width))),
                    cvRound(std::clamp(box.y, 0.0, double(size.height))));
  const cv::Point b(cvRound(std::clamp(box.x + box.width, 0.0, double(size.width))),
                    cvRound(std::clamp(box.y + box.height, 0.0, double(size.height))));
  return {a, b};
}

// Without the darkest fifth and the brightest tenth, then without what is far from the median of hue and saturation.
std::vector<ToneColour> trimmed(std::vector<ToneColour> colours) {
  std::sort(colours.begin(), colours.end(), [](const ToneColour& a, const ToneColour& b) {
    return a.v != b.v ? a.v < b.v : a.x != b.x ? a.x < b.x : a.y < b.y;
  });
  colours.erase(colours.end() - std::ptrdiff_t(colours.size() / 10), colours.end());
  colours.erase(colours.begin(), colours.begin() + std::ptrdiff_t(colours.size() / 5));
  if (colours.empty()) return colours;
  const auto median = [](std::vector<double> values) {
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  const auto all = [&](auto of) {
    std::vector<double> values;
    values.reserve(colours.size());
    for (const auto& c : colours) values.push_back(of(c));
    return values;
  };
  const double x = median(all([](const ToneColour& c) { return c.x; }));
  const double y = median(all([](const ToneColour& c) { return c.y; }));
  const auto away = [&](const ToneColour& c) { return std::hypot(c.x - x, c.y - y); };
  const double most = 3 * std::max(median(all(away)), 0.005);
  std::erase_if(colours, [&](const ToneColour& c) { return away(c) > most; });
  return colours;
}

// Every pixel of the area, or where they are many, evenly spread ones.
void gather(const cv::Mat& picture, const cv::Mat& body, const cv::Rect& area, std::vector<ToneColour>& out) {
  constexpr double kEnough = 600;
  const int step = std::max(1, static_cast<int>(std::sqrt(area.area() / kEnough)));
  for (int y = area.y; y < area.y + area.height; y += step) {
    const auto* p = picture.ptr<cv::Vec3b>(y);
    const auto* m = body.empty() ? nullptr : body.ptr<std::uint8_t>(y);
    for (int x = area.x; x < area.x + area.width; x += step) {
      if (m == nullptr || m[x] != 0) out.push_back(tone_colour(p[x]));
    }
  }
}

// From one look to the next.
double step_since(const std::optional<double>& last_s, double time_s) {
  return last_s ? std::clamp(time_s - *last_s, 0.0, kMostLookStep_s) : 0.0;
}

cv::Vec3d mean_of(const std::vector<ToneColour>& colours) {
  cv::Vec3d sum;
  for (const auto& c : colours) sum += cv::Vec3d(c.x, c.y, c.v);
  return sum * (1.0 / double(colours.size()));
}

// Wider by shares of the saturation along it and across it.
void widen(cv::Matx33d& covariance, const cv::Vec3d& mean) {
  const double along = kAlongSaturation * kAlongSaturation;
  const double across = kAcrossSaturation * kAcrossSaturation;
  const double x = mean[0];
  const double y = mean[1];
  covariance(0, 0) += along * x * x + across * y * y + kEverywhere * kEverywhere;
  covariance(1, 1) += along * y * y + across * x * x + kEverywhere * kEverywhere;
  covariance(0, 1) += (along - across) * x * y;
  covariance(1, 0) = covariance(0, 1);
}

// Mahalanobis' distance of two tones by the mean of their covariances.
double apart(const GaussianTone::Parameters& a, const GaussianTone::Parameters& b) {
  const auto mean = [&](int i, int j) { return 0.5 * (a.covariance(i, j) + b.covariance(i, j)); };
  const auto d = a.mean - b.mean;
  const double determinant = mean(0, 0) * mean(1, 1) - mean(0, 1) * mean(0, 1);
  const double plane = mean(1, 1) * d[0] * d[0] - 2 * mean(0, 1) * d[0] * d[1] + mean(0, 0) * d[1] * d[1];
  return std::sqrt(plane / determinant + d[2] * d[2] / mean(2, 2));
}

}  // namespace

std::vector<cv::Rect> skin_areas(const TrackedFace& face, cv::Size picture) {
  const double w = face.width;
  const auto c = face.centre;
  std::vector<cv::Rect> areas;
  for (const auto& area : {cut(c.x - 0.34 * w, c.y + 0.04 * w, c.x - 0.11 * w, c.y + 0.27 * w, picture),
                           cut(c.x + 0.11 * w, c.y + 0.04 * w, c.x + 0.34 * w, c.y + 0.27 * w, picture),
                           cut(c.x - 0.20 * w, c.y - 0.42 * w, c.x + 0.20 * w, c.y - 0.28 * w, picture)}) {
    if (!area.empty()) areas.push_back(area);
  }
  return areas;
}

std::array<cv::Rect, 2> clothes_areas(const TrackedFace& face, cv::Size picture) {
  const double w = face.width;
  const auto c = face.centre;
  return {cut(c.x - 0.45 * w, c.y + 1.5 * w, c.x + 0.45 * w, c.y + 2.3 * w, picture),
          cut(c.x - 0.55 * w, c.y + 4.5 * w, c.x + 0.55 * w, c.y + 5.8 * w, picture)};
}

void ToneLearner::Gathered::fade(double factor) {
  weight *= factor;
  sum *= factor;
  squares *= factor;
  for (auto& cell : cells) cell *= static_cast<float>(factor);
}

void ToneLearner::Gathered::add(const std::vector<ToneColour>& colours) {
  for (const auto& c : colours) {
    const cv::Vec3d at(c.x, c.y, c.v);
    weight += 1;
    sum += at;
    squares += at * at.t();
    if (!cells.empty()) cells[HistogramTone::cell_of(c.x, c.y)] += 1;
  }
}

cv::Matx33d ToneLearner::Gathered::covariance() const {
  const auto m = mean();
  return squares * (1 / weight) - m * m.t();
}

ToneLearner::ToneLearner(const ToneOptions& options) : options_(options) {
  options_.validate();
  if (options_.model == ToneKind::kHistogram) {
    face_.cells.assign(std::size_t(HistogramTone::kCells) * HistogramTone::kCells, 0.0F);
    for (auto& worn : worn_) worn.cells = face_.cells;
  }
}

bool ToneLearner::alike(const std::vector<ToneColour>& colours) const {
  if (face_.weight < kLeastGathered) return true;
  const auto was = face_.mean();
  const auto is = mean_of(colours);
  const double saturation = std::hypot(was[0], was[1]);
  const double ratio = is[2] / std::max(was[2], 1e-3);
  return std::hypot(is[0] - was[0], is[1] - was[1]) < 0.06 + 0.25 * saturation && ratio > 0.6 && ratio < 1.6;
}

bool ToneLearner::add(const cv::Mat& picture, const TrackedFace& face, double time_s, const cv::Mat& body) {
  assert(picture.type() == CV_8UC3);
  assert(body.empty() || (body.type() == CV_8UC1 && body.size() == picture.size()));
  if (!(face.width > 0) || face.unseen_s > kMostUnseen_s) return false;
  std::vector<ToneColour> colours;
  for (const auto& area : skin_areas(face, picture.size())) gather(picture, {}, area, colours);
  colours = trimmed(std::move(colours));
  if (colours.size() < kLeastPixels) return false;

  if (!alike(colours)) {
    // Of looks, not of time: two odd ones with the face hidden in between tell nothing of what was there.
    unlike_s_ += step_since(unlike_at_s_, time_s);
    unlike_at_s_ = time_s;
    if (unlike_s_ < kUnlike_s - 1e-9) return false;
    reset();
  }
  unlike_at_s_.reset();
  unlike_s_ = 0;

  const double step = step_since(last_s_, time_s);
  last_s_ = time_s;
  bool last_chance = false;
  if (learned_s_ < options_.learn_s) {
    learned_s_ = std::min(options_.learn_s, learned_s_ + step);
    last_chance = options_.adapt_s == 0 && learned_s_ == options_.learn_s;
  } else if (options_.adapt_s > 0) {
    const double factor = std::exp(-step / options_.adapt_s);
    face_.fade(factor);
    for (auto& worn : worn_) worn.fade(factor);
  } else if (skin_) {
    return false;
  }
  face_.add(colours);
  if (options_.learn_clothes) {
    const auto areas = clothes_areas(face, picture.size());
    for (std::size_t i = 0; i < areas.size(); ++i) {
      std::vector<ToneColour> worn;
      gather(picture, body, areas[i], worn);
      worn_[i].add(trimmed(std::move(worn)));
    }
  }
  if (face_.weight < kLeastGathered) return false;
  // Half a millisecond of grace: time stamps are rounded. What never adapts is never looked at again.
  if (!last_chance && given_s_ && time_s - *given_s_ < options_.rebuild_s - 5e-4) return false;
  given_s_ = time_s;
  give_out();
  return true;
}

void ToneLearner::give_out() {
  const auto skin = arms_of(face_, kValueShare, options_.noise);
  skin_ = Tone{"skin", options_.skin_prior, {{1, model_of(face_, skin)}}};
  Tone clothes{"clothes", kClothesPrior, {}};
  for (const auto& worn : worn_) {
    if (worn.weight < kLeastGathered) continue;
    const auto parameters = arms_of(worn, kClothesValueShare, options_.noise);
    if (apart(skin, parameters) >= kLeastApart) clothes.parts.push_back({1, model_of(worn, parameters)});
  }
  clothes_ = clothes.parts.empty() ? std::nullopt : std::optional(std::move(clothes));
}

std::shared_ptr<const ToneModel> ToneLearner::model_of(const Gathered& from,
                                                       const GaussianTone::Parameters& parameters) const {
  if (options_.model == ToneKind::kGaussian) return std::make_shared<GaussianTone>(parameters);
  HistogramTone::Parameters p;
  p.weights = from.cells;
  p.value = {parameters.mean[2], std::sqrt(parameters.covariance(2, 2))};
  p.noise = options_.noise;
  // As wide as the normal density is wider than the pixels.
  const auto own = from.covariance();
  const auto& wide = parameters.covariance;
  p.smoothing = std::clamp(std::sqrt(0.5 * (wide(0, 0) + wide(1, 1) - own(0, 0) - own(1, 1))), 0.005, 0.5);
  return std::make_shared<HistogramTone>(std::move(p));
}

GaussianTone::Parameters ToneLearner::arms_of(const Gathered& from, double value_share, double noise) {
  GaussianTone::Parameters p;
  p.mean = from.mean();
  p.covariance = from.covariance();
  p.noise = noise;
  widen(p.covariance, p.mean);
  // v bears on the tone by itself: how the face is shaded says little of how the arms are.
  for (int i = 0; i < 2; ++i) p.covariance(i, 2) = p.covariance(2, i) = 0;
  const double deviation = kValueDeviation * p.mean[2] + 0.02;
  p.covariance(2, 2) += deviation * deviation;
  p.mean[2] *= value_share;
  return p;
}

}  // namespace choreo::vision
