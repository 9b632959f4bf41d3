// SPDX-License-Identifier: Apache-2.0
#include "vision/background_estimate.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <opencv2/imgproc.hpp>

#include "vision/difference.hpp"
#include "vision/tone_curve.hpp"

namespace choreo::vision {
namespace {

constexpr double kLeastThreshold = 10.0;    // Grey levels; compression and rounding alone reach half of it.
constexpr double kThresholdPerNoise = 5.0;  // Beyond this many standard deviations a pixel is not the sensor's noise.
constexpr double kLeastBody = 0.005;        // Of the picture; less is no body.

// Median of half-normal noise over its standard deviation lies between 0.67 (channels in step) and 0.8 (independent).
constexpr double kMedianPerNoise = 0.75;

// Picture, plate and D are rounded to whole levels, and each rounding adds a variance of 1/12.
constexpr double kRounding = 3.0 / 12.0;

double threshold_of(double noise) { return std::max(kLeastThreshold, kThresholdPerNoise * noise); }

double lower_quartile(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 4);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

cv::Mat foreground(const cv::Mat& picture, const cv::Mat& plate, double threshold) {
  return difference_luminance(picture, plate) > threshold;
}

double share(const cv::Mat& mask) { return double(cv::countNonZero(mask)) / double(mask.total()); }

// Per pixel the mean of the commonest colour cluster.
cv::Mat commonest_colours(std::span<const cv::Mat> pictures, double noise) {
  const auto size = pictures.front().size();
  const int radius = static_cast<int>(std::lround(std::max(10.0, 4.0 * noise)));
  cv::Mat plate(size, CV_8UC3);
  struct Cluster {
    std::array<int, 3> mean{};
    std::array<int, 3> sum{};
    int count = 0;
  };
  tbb::parallel_for(tbb::blocked_range<int>(0, size.height), [&](const tbb::blocked_range<int>& rows) {
    std::vector<const std::uint8_t*> lines(pictures.size());
    for (int y = rows.begin(); y < rows.end(); ++y) {
      for (std::size_t k = 0; k < pictures.size(); ++k) lines[k] = pictures[k].ptr<std::uint8_t>(y);
      auto* out = plate.ptr<std::uint8_t>(y);
      for (int x = 0; x < size.width; ++x) {
        std::array<Cluster, 4> clusters{};
        std::size_t used = 0;
        for (const auto* line : lines) {
          const auto* p = line + 3 * x;
          Cluster* home = nullptr;
          for (std::size_t c = 0; c < used && home == nullptr; ++c) {
            auto& m = clusters[c].mean;
            if (std::abs(p[0] - m[0]) <= radius && std::abs(p[1] - m[1]) <= radius && std::abs(p[2] - m[2]) <= radius) {
              home = &clusters[c];
            }
          }
          if (home == nullptr) {
            if (used < clusters.size()) {
              home = &clusters[used++];
            } else {
              // The rarest makes room: a wall seen often cannot be it.
              home = &*std::min_element(clusters.begin(), clusters.end(),
                                        [](const Cluster& a, const Cluster& b) { return a.count < b.count; });
              *home = Cluster{};
            }
          }
          ++home->count;
          for (std::size_t c = 0; c < 3; ++c) {
            home->sum[c] += p[c];
            home->mean[c] = (home->sum[c] + home->count / 2) / home->count;
          }
        }
        const auto& best = *std::max_element(clusters.begin(), clusters.end(),
                                             [](const Cluster& a, const Cluster& b) { return a.count < b.count; });
        for (std::size_t c = 0; c < 3; ++c) out[3 * x + int(c)] = static_cast<std::uint8_t>(best.mean[c]);
      }
    }
  });
  return plate;
}

// How strong an edge a picture has along a region's border, in grey levels.
double border_contrast(const cv::Mat& grey, const cv::Mat& border) {
  const cv::Mat square = cv::getStructuringElement(cv::MORPH_RECT, {5, 5});
  cv::Mat gradient;
  cv::morphologyEx(grey, gradient, cv::MORPH_GRADIENT, square);
  return cv::mean(gradient, border)[0];
}

cv::Mat grey_of(const cv::Mat& picture) {
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  cv::blur(grey, grey, {3, 3});
  return grey;
}

// Takes from `other` every region in which it differs from `plate` and has the weaker outline.
void take_unoutlined(cv::Mat& plate, const cv::Mat& other, double threshold) {
  cv::Mat differing = annealed(foreground(other, plate, threshold), 2);
  differing = without_specks(differing, static_cast<int>(kLeastBody / 5 * double(plate.total())) + 1, false);
  cv::Mat labels;
  const int count = cv::connectedComponents(differing, labels, 8, CV_32S, cv::CCL_SAUF);
  const cv::Mat square = cv::getStructuringElement(cv::MORPH_RECT, {3, 3});
  for (int i = 1; i < count; ++i) {
    const cv::Mat region = labels == i;
    cv::Mat border;
    cv::morphologyEx(region, border, cv::MORPH_GRADIENT, square);
    cv::Mat swapped = plate.clone();
    cv::Mat grown;
    cv::dilate(region, grown, square);  // The blended pixels of the outline go with the body.
    other.copyTo(swapped, grown);
    if (border_contrast(grey_of(swapped), border) < border_contrast(grey_of(plate), border)) plate = swapped;
  }
}

}  // namespace

cv::Mat median_plate(std::span<const cv::Mat> pictures) {
  assert(!pictures.empty());
  const auto size = pictures.front().size();
  cv::Mat plate(size, CV_8UC3);
  tbb::parallel_for(tbb::blocked_range<int>(0, size.height), [&](const tbb::blocked_range<int>& rows) {
    std::vector<std::uint8_t> values(pictures.size());
    for (int y = rows.begin(); y < rows.end(); ++y) {
      auto* out = plate.ptr<std::uint8_t>(y);
      for (int i = 0; i < 3 * size.width; ++i) {
        for (std::size_t k = 0; k < pictures.size(); ++k) values[k] = pictures[k].ptr<std::uint8_t>(y)[i];
        const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
        std::nth_element(values.begin(), middle, values.end());
        out[i] = *middle;
      }
    }
  });
  return plate;
}

namespace {

std::vector<cv::Mat> in_each_light(const cv::Mat& plate, std::span<const cv::Mat> pictures) {
  std::vector<cv::Mat> lit;
  for (const auto& picture : pictures) lit.push_back(ToneCurve(plate, picture).apply(plate));
  return lit;
}

double noise_between(std::span<const cv::Mat> pictures, std::span<const cv::Mat> lit) {
  std::vector<double> medians;
  for (std::size_t k = 0; k < pictures.size(); ++k) {
    medians.push_back(interpolated_median(difference_luminance(pictures[k], lit[k])));
  }
  const double rounded_noise = lower_quartile(medians) / kMedianPerNoise;
  return std::sqrt(std::max(0.0, rounded_noise * rounded_noise - kRounding));
}

}  // namespace

double noise_before(const cv::Mat& plate, std::span<const cv::Mat> pictures) {
  assert(!pictures.empty());
  return noise_between(pictures, in_each_light(plate, pictures));
}

BackgroundEstimate judge_plate(const cv::Mat& plate, std::span<const cv::Mat> pictures) {
  assert(!pictures.empty());
  BackgroundEstimate estimate;
  estimate.plate = plate;
  const auto lit = in_each_light(plate, pictures);
  estimate.noise = noise_between(pictures, lit);
  const double threshold = threshold_of(estimate.noise);
  estimate.dynamic = DynamicBackground(pictures, lit, threshold);
  const int speck = std::max(2, static_cast<int>(0.0002 * double(plate.total())));
  std::vector<cv::Mat> masks;
  cv::Mat ever = cv::Mat::zeros(plate.size(), CV_8UC1);
  // Where the wall was seen while the body was elsewhere.
  cv::Mat bare = cv::Mat::zeros(plate.size(), CV_8UC1);
  for (std::size_t k = 0; k < pictures.size(); ++k) {
    const cv::Mat mask = without_specks(annealed(foreground(pictures[k], lit[k], threshold), 2), speck, false);
    ever |= mask;
    if (share(mask) < kLeastBody) {
      bare = 255;
      continue;
    }
    auto box = cv::boundingRect(mask);
    const int margin = std::max(box.width, box.height) / 10;
    box = cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
          cv::Rect({0, 0}, plate.size());
    cv::Mat elsewhere(plate.size(), CV_8UC1, cv::Scalar(255));
    elsewhere(box) = 0;
    bare |= elsewhere;
    masks.push_back(mask);
  }
  estimate.empty = double(pictures.size() - masks.size()) / double(pictures.size());
  const cv::Mat doubtful = ~(ever | bare);
  double sum = 0;
  for (const auto& mask : masks) {
    const cv::Mat hull = hull_of(mask);
    sum += double(cv::countNonZero(hull & doubtful)) / double(std::max(1, cv::countNonZero(hull)));
  }
  if (!masks.empty()) estimate.unseen = sum / double(masks.size());
  return estimate;
}

BackgroundEstimate estimate_beginning(std::span<const cv::Mat> pictures, std::span<const cv::Mat> quiet) {
  cv::Mat plate = median_plate(pictures);
  for (const auto& candidate : quiet) {
    take_unoutlined(plate, ToneCurve(candidate, plate).apply(candidate), kLeastThreshold);
  }
  return judge_plate(plate, pictures);
}

BackgroundEstimate estimate_background(std::span<const cv::Mat> pictures, std::span<const cv::Mat> quiet) {
  assert(!pictures.empty());
  const cv::Mat reference = quiet.empty() ? pictures[pictures.size() / 2] : quiet.front();
  std::vector<cv::Mat> alike;
  for (const auto& picture : pictures) alike.push_back(ToneCurve(picture, reference).apply(picture));

  // Noise from neighbours in time, whose difference has twice the variance; most of the picture does not move.
  std::vector<double> medians;
  for (std::size_t k = 1; k < alike.size(); ++k) {
    medians.push_back(interpolated_median(difference_luminance(alike[k], alike[k - 1])));
  }
  const double noise = lower_quartile(medians) / (kMedianPerNoise * std::sqrt(2.0));

  cv::Mat plate = commonest_colours(alike, noise);
  for (const auto& candidate : quiet) {
    take_unoutlined(plate, ToneCurve(candidate, reference).apply(candidate), threshold_of(noise));
  }
  return judge_plate(plate, pictures);
}

}  // namespace choreo::vision
