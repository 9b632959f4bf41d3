// SPDX-License-Identifier: Apache-2.0
// Pose models that can be told what to find: somebody is where anything white is.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "vision/person/person_network.hpp"
#include "vision/tiny_network.hpp"

namespace choreo::test {

/// Six numbers after one another in a row of `count` become `tensor`'s output.
class TinyPose : public TinyNetwork {
 public:
  explicit TinyPose(int size) : size_(size) {
    in_ = input({1, size, size, 3});
    tflite::Pool2DOptionsT whole;
    whole.padding = tflite::Padding::VALID;
    whole.filter_height = whole.filter_width = size;
    whole.stride_h = whole.stride_w = 1;
    brightest_ = node(tflite::BuiltinOperator::MAX_POOL_2D, {in_}, {1, 1, 1, 3}, whole);
  }

  /// An output: `numbers`, and `gain` times the brightest red.
  void constant(const std::vector<float>& numbers, std::vector<int> shape, float gain = 0) {
    const int count = int(numbers.size());
    std::vector<float> weights;
    for (int k = 0; k < count; ++k) weights.insert(weights.end(), {gain, 0, 0});
    const int row =
        node(tflite::BuiltinOperator::CONV_2D,
             {brightest_, floats({count, 1, 1, 3}, weights), floats({count}, numbers)}, {1, 1, 1, count}, pointwise());
    output(node(tflite::BuiltinOperator::RESHAPE, {row}, std::move(shape)));
  }
  /// An output that is 1 where anything is white, and 0 where all is black.
  void score() {
    const int odds =
        node(tflite::BuiltinOperator::CONV_2D, {brightest_, floats({1, 1, 1, 3}, {40, 0, 0}), floats({1}, {-20})},
             {1, 1, 1, 1}, pointwise());
    const int score = node(tflite::BuiltinOperator::LOGISTIC, {odds}, {1, 1, 1, 1});
    output(node(tflite::BuiltinOperator::RESHAPE, {score}, {1, 1}));
  }
  /// An output of the picture's size: far above 0 where it is white, far below where it is black.
  void silhouette() {
    output(node(tflite::BuiltinOperator::CONV_2D, {in_, floats({1, 1, 1, 3}, {40, 0, 0}), floats({1}, {-20})},
                {1, size_, size_, 1}, pointwise()));
  }

 private:
  static tflite::Conv2DOptionsT pointwise() {
    tflite::Conv2DOptionsT options;
    options.stride_h = options.stride_w = 1;
    return options;
  }

  int size_;
  int in_, brightest_;
};

/// Joints at fixed places of whatever region is looked at.
/// @param points  x, y, depth, and the logits of visibility and presence, in a region of 256 x 256; of 39 points those
///   that are missing are 0.
inline std::vector<std::uint8_t> tiny_landmarks(const std::vector<std::array<float, 5>>& points) {
  TinyPose pose(256);
  std::vector<float> numbers;
  for (const auto& p : points) numbers.insert(numbers.end(), p.begin(), p.end());
  numbers.resize(39 * 5);
  pose.constant(numbers, {1, 39 * 5});
  pose.score();
  pose.silhouette();
  std::vector<float> metres(39 * 3);
  for (std::size_t k = 0; k < metres.size(); ++k) metres[k] = float(k) / 100;
  pose.constant(metres, {1, 39 * 3});
  return pose.file();
}

/// Somebody whose hips and reach are at these places of the whole picture's square of 224 x 224.
inline std::vector<std::uint8_t> tiny_detector(cv::Point2f hips, cv::Point2f reach) {
  constexpr int kAnchors = 2254;
  TinyPose pose(224);
  // Of the first anchor, in the middle of the first cell of 8 pixels.
  std::vector<float> boxes(12 * kAnchors);
  const std::array<float, 12> first = {hips.x - 4,  hips.y - 4,  40,         40, hips.x - 4,  hips.y - 4,
                                       reach.x - 4, reach.y - 4, hips.x - 4, 0,  reach.x - 4, 0};
  std::copy(first.begin(), first.end(), boxes.begin());
  pose.constant(boxes, {1, kAnchors, 12});
  // White is 1 and black is -1 for the detector.
  std::vector<float> scores(kAnchors, -100);
  scores[0] = 0;
  pose.constant(scores, {1, kAnchors, 1}, 10);
  return pose.file();
}

/// A person in the middle of the region, upright, who reaches 50 of its 256 pixels upwards from the hips.
inline vision::PersonSearch tiny_search(vision::PersonChoice choice = vision::PersonChoice::kLargest) {
  std::vector<std::array<float, 5>> points(39, {128, 128, 0, 10, 10});
  points[0] = {128, 88, -5, 10, 10};    // The nose,
  points[15] = {188, 108, 3, -10, 10};  // the left wrist, hidden,
  points[34] = {128, 78, 0, 10, 10};    // and how far it all reaches.
  return {vision::PersonNetwork(tiny_landmarks(points)), vision::PersonDetector(tiny_detector({112, 112}, {112, 72})),
          choice};
}

}  // namespace choreo::test
