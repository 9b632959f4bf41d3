// SPDX-License-Identifier: Apache-2.0
// A convolutional network as a list of operations on tensors.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

namespace choreo::vision {

/// Height first, as everywhere in a network.
struct PixelPair {
  int y = 1;
  int x = 1;
};

/// Pixels beside a picture that count as zero.
struct PixelMargin {
  int top = 0, bottom = 0, left = 0, right = 0;
};

/// What a number of operations has done with numbers.
struct NetworkTensor {
  std::vector<int> shape;       ///< 1 to 4 sizes; of pictures 1, height, width, channels.
  std::vector<float> constant;  ///< In order of its indices, the last one fastest; empty: computed, or given.

  [[nodiscard]] std::size_t count() const;
};

enum class NetworkOperation {
  kConvolution,     ///< Of picture, weights (out, height, width, in) and bias (out).
  kDepthwise,       ///< Likewise, every channel by itself; weights (1, height, width, channels).
  kAdd,             ///< Two tensors of one shape.
  kMaximum,         ///< Of every window; what is outside does not count.
  kResizeBilinear,  ///< To the size of the output; pixels are squares, and the pictures share their outer border.
  kReshape,
  kDepthToSpace,  ///< A square of pixels from the channels of one.
  kSigmoid,
  kClamp,
};

struct NetworkNode {
  NetworkOperation operation = NetworkOperation::kAdd;
  std::vector<int> inputs;  ///< Numbers of tensors.
  int output = 0;
  PixelMargin margin;  ///< Of convolutions and windows.
  PixelPair kernel, stride;
  float least = -std::numeric_limits<float>::infinity();  ///< What is below becomes this.
  float most = std::numeric_limits<float>::infinity();
  int block = 1;  ///< Of kDepthToSpace: the square's side.
};

/// One tensor, or several that follow each other.
struct NetworkOutput {
  std::vector<int> parts;
  std::vector<int> shape;
};

/// Every node reads what is constant, given or written by a node before it; every shape is what the node makes.
struct NetworkGraph {
  std::vector<NetworkTensor> tensors;
  std::vector<NetworkNode> nodes;
  int input = 0;                       ///< 1, height, width, channels.
  std::vector<NetworkOutput> outputs;  ///< At least one.
};

}  // namespace choreo::vision
