// SPDX-License-Identifier: Apache-2.0
#include "vision/person/person_network.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string_view>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "core/error.hpp"
#include "vision/network/tflite_reader.hpp"

namespace choreo::vision {
namespace {

constexpr double kMore = 1.25;  // Of the body's reach, for what it does until the next look.
constexpr std::size_t kNumbersOfPoint = 5;
constexpr std::size_t kAllPoints = 39;  // The last six are for regions.

double logistic(double x) { return 1 / (1 + std::exp(-x)); }

// The picture reduced so far that nothing is lost between the pixels of the region.
cv::Mat reduced_for(const cv::Mat& picture, double side, int size) {
  const double scale = side / (1.5 * size);
  if (scale <= 1.0) return picture;
  cv::Mat small;
  const cv::Size to(std::max(1, cvRound(picture.cols / scale)), std::max(1, cvRound(picture.rows / scale)));
  cv::resize(picture, small, to, 0, 0, cv::INTER_AREA);
  return small;
}

// `from_picture` for a picture that was reduced, by factors that whole pixels make differ a little.
cv::Matx23d from_reduced(const cv::Matx23d& m, cv::Size picture, cv::Size reduced) {
  const double sx = double(picture.width) / reduced.width;
  const double sy = double(picture.height) / reduced.height;
  const double x = (sx - 1) / 2;  // Of the reduced picture's first pixel.
  const double y = (sy - 1) / 2;
  return {m(0, 0) * sx, m(0, 1) * sy, m(0, 0) * x + m(0, 1) * y + m(0, 2),
          m(1, 0) * sx, m(1, 1) * sy, m(1, 0) * x + m(1, 1) * y + m(1, 2)};
}

// Fills the network's input with the region, red first, from `least` to 1.
void give(Network& network, const cv::Mat& picture, const PersonRegion& region, float least) {
  const int size = network.input_shape()[1];
  const auto small = reduced_for(picture, region.side, size);
  const auto map = from_reduced(region.from_picture(size), picture.size(), small.size());
  cv::Mat part;
  cv::warpAffine(small, part, cv::Mat(map), {size, size}, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  float* to = network.input().data();
  const float gain = (1.0F - least) / 255.0F;
  for (int y = 0; y < size; ++y) {
    const auto* from = part.ptr<std::uint8_t>(y);
    for (int x = 0; x < size; ++x, from += 3, to += 3) {
      to[0] = least + gain * float(from[2]);
      to[1] = least + gain * float(from[1]);
      to[2] = least + gain * float(from[0]);
    }
  }
}

std::size_t output_of(const Network& network, const std::vector<int>& shape, std::string_view what) {
  for (std::size_t k = 0; k < network.outputs(); ++k) {
    if (network.output_shape(k) == shape) return k;
  }
  throw usage_error(fmt::format("the network gives no {}", what), {},
                    "the pose models of the npm package @mediapipe/pose are what is read");
}

std::vector<int> input_of(int size) { return {1, size, size, 3}; }

void require_input(const Network& network, int size) {
  if (network.input_shape() == input_of(size)) return;
  throw usage_error(fmt::format("the network does not look at {0} x {0} pixels", size), {},
                    "the pose models of the npm package @mediapipe/pose are what is read");
}

double overlap(const cv::Rect2d& a, const cv::Rect2d& b) {
  const double both = (a & b).area();
  return both <= 0 ? 0 : both / (a.area() + b.area() - both);
}

}  // namespace

cv::Matx23d PersonRegion::from_picture(int size) const {
  const double scale = size / side;
  const double c = scale * std::cos(angle);
  const double s = scale * std::sin(angle);
  const double middle = (size - 1) / 2.0;
  return {c, s, middle - c * centre.x - s * centre.y, -s, c, middle + s * centre.x - c * centre.y};
}

cv::Mat silhouette_in_picture(const PersonLook& look, cv::Size size) {
  cv::Mat whole;
  cv::warpAffine(look.silhouette, whole, cv::Mat(look.region.from_picture(look.silhouette.cols)), size,
                 cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_CONSTANT);
  return whole;
}

PersonRegion region_of(cv::Point2d hips, cv::Point2d reach) {
  const auto up = reach - hips;
  return {hips, std::max(1.0, 2 * kMore * std::hypot(up.x, up.y)), std::atan2(up.x, -up.y)};
}

PersonNetwork::PersonNetwork(std::span<const std::uint8_t> model) : network_(read_tflite(model)) {
  constexpr int kSize = 256;
  require_input(network_, kSize);
  points_ = output_of(network_, {1, int(kAllPoints * kNumbersOfPoint)}, "joints");
  metres_ = output_of(network_, {1, int(kAllPoints * 3)}, "joints in metres");
  score_ = output_of(network_, {1, 1}, "score");
  silhouette_ = output_of(network_, {1, kSize, kSize, 1}, "silhouette");
}

PersonLook PersonNetwork::look(const cv::Mat& picture, const PersonRegion& region) {
  assert(picture.type() == CV_8UC3 && !picture.empty() && region.side >= 1);
  const int size = network_.input_shape()[1];
  give(network_, picture, region, 0);
  network_.run();

  PersonLook look;
  look.region = region;
  look.score = network_.output(score_)[0];
  const double scale = region.side / size;
  const double c = scale * std::cos(region.angle);
  const double s = scale * std::sin(region.angle);
  const auto numbers = network_.output(points_);
  const auto in_picture = [&](std::size_t k) {
    // The network counts from the outer border of the first pixel.
    const double x = double(numbers[kNumbersOfPoint * k]) - size / 2.0;
    const double y = double(numbers[kNumbersOfPoint * k + 1]) - size / 2.0;
    return region.centre + cv::Point2d(c * x - s * y, s * x + c * y);
  };
  const auto metres = network_.output(metres_);
  const cv::Point2d turn(std::cos(region.angle), std::sin(region.angle));
  for (std::size_t k = 0; k < kPersonPoints; ++k) {
    const auto* point = &numbers[kNumbersOfPoint * k];
    look.points[k] = {in_picture(k), scale * double(point[2]), logistic(double(point[3])), logistic(double(point[4]))};
    const double x = double(metres[3 * k]);
    const double y = double(metres[3 * k + 1]);
    look.metres[k] = {turn.x * x - turn.y * y, turn.y * x + turn.x * y, double(metres[3 * k + 2])};
  }
  look.next = region_of(in_picture(kPersonPoints), in_picture(kPersonPoints + 1));
  // Numbers beyond what floats hold are no person's.
  const bool finite = std::ranges::all_of(numbers, [](float x) { return std::isfinite(x); });
  if (!finite || !std::isfinite(look.score)) look.score = 0;
  look.silhouette.create(size, size, CV_8UC1);
  const auto odds = network_.output(silhouette_);
  std::transform(odds.begin(), odds.end(), look.silhouette.begin<std::uint8_t>(), [](float x) {
    return static_cast<std::uint8_t>(0.5F + 255 / (1 + std::exp(-std::clamp(x, -80.0F, 80.0F))));
  });
  return look;
}

PersonDetector::PersonDetector(std::span<const std::uint8_t> model) : network_(read_tflite(model)) {
  constexpr int kSize = 224;
  require_input(network_, kSize);
  // Two anchors in the middle of each cell of 8 and 16 pixels, six in that of each of 32.
  for (const auto& [cell, count] : {std::pair{8, 2}, {16, 2}, {32, 6}}) {
    const int cells = kSize / cell;
    for (int y = 0; y < cells; ++y) {
      for (int x = 0; x < cells; ++x) {
        for (int k = 0; k < count; ++k) anchors_.emplace_back((x + 0.5) / cells, (y + 0.5) / cells);
      }
    }
  }
  const int all = int(anchors_.size());
  boxes_ = output_of(network_, {1, all, 12}, "boxes");
  scores_ = output_of(network_, {1, all, 1}, "scores");
}

std::vector<DetectedPerson> PersonDetector::detect(const cv::Mat& picture) {
  assert(picture.type() == CV_8UC3 && !picture.empty());
  constexpr double kLeastScore = 0.5;
  constexpr double kSamePerson = 0.3;  // Overlap of two boxes.
  const int size = network_.input_shape()[1];
  const PersonRegion whole{
      {(picture.cols - 1) / 2.0, (picture.rows - 1) / 2.0}, double(std::max(picture.cols, picture.rows)), 0};
  give(network_, picture, whole, -1);
  network_.run();

  const auto boxes = network_.output(boxes_);
  const auto scores = network_.output(scores_);
  const auto in_picture = [&](double x, double y) {
    return whole.centre + cv::Point2d((x - 0.5) * whole.side, (y - 0.5) * whole.side);
  };
  struct Candidate {
    double score;
    std::array<double, 12> numbers;  // Middle, size and four points, 0 to 1.
    cv::Rect2d box;
  };
  std::vector<Candidate> candidates;
  for (std::size_t k = 0; k < anchors_.size(); ++k) {
    const double score = logistic(std::clamp(double(scores[k]), -100.0, 100.0));
    const auto numbers = boxes.subspan(12 * k, 12);
    if (!(score >= kLeastScore) || !std::ranges::all_of(numbers, [](float x) { return std::isfinite(x); })) continue;
    Candidate c{score, {}, {}};
    for (std::size_t i = 0; i < c.numbers.size(); ++i) {
      const double anchor = i == 2 || i == 3 ? 0.0 : i % 2 == 0 ? anchors_[k].x : anchors_[k].y;
      c.numbers[i] = double(boxes[c.numbers.size() * k + i]) / size + anchor;
    }
    c.box = {c.numbers[0] - c.numbers[2] / 2, c.numbers[1] - c.numbers[3] / 2, c.numbers[2], c.numbers[3]};
    candidates.push_back(c);
  }
  std::ranges::stable_sort(candidates, std::greater<>(), &Candidate::score);
  std::vector<DetectedPerson> people;
  while (!candidates.empty()) {
    // Those that mean the same person are averaged by their scores.
    const auto best = candidates.front();
    std::array<double, 12> mean{};
    double sum = 0;
    std::vector<Candidate> rest;
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      const auto& c = candidates[k];
      if (k > 0 && overlap(best.box, c.box) <= kSamePerson) {
        rest.push_back(c);
        continue;
      }
      sum += c.score;
      for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += c.score * c.numbers[i];
    }
    for (auto& x : mean) x /= sum;
    candidates = std::move(rest);
    const auto corner = in_picture(mean[0] - mean[2] / 2, mean[1] - mean[3] / 2);
    const cv::Rect2d box(corner.x, corner.y, mean[2] * whole.side, mean[3] * whole.side);
    people.push_back({region_of(in_picture(mean[4], mean[5]), in_picture(mean[6], mean[7])), box, best.score});
  }
  return people;
}

}  // namespace choreo::vision
