// SPDX-License-Identifier: Apache-2.0
#include "vision/plain_network.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace choreo::test {
namespace {

using vision::NetworkGraph;
using vision::NetworkNode;
using vision::NetworkOperation;

// Numbers by their place in a picture; what lies outside is 0.
struct Plane {
  std::vector<int> shape;
  std::vector<double> numbers;

  explicit Plane(std::vector<int> sizes) : shape(std::move(sizes)) {
    std::size_t count = 1;
    for (const int s : shape) count *= std::size_t(s);
    numbers.assign(count, 0.0);
  }
  [[nodiscard]] bool inside(int y, int x) const { return y >= 0 && x >= 0 && y < shape[1] && x < shape[2]; }
  double& at(int y, int x, int c) {
    return numbers[(std::size_t(y) * std::size_t(shape[2]) + std::size_t(x)) * std::size_t(shape[3]) + std::size_t(c)];
  }
  [[nodiscard]] double get(int y, int x, int c) const {
    return inside(y, x) && c < shape[3] ? const_cast<Plane*>(this)->at(y, x, c) : 0.0;
  }
};

double resized(const Plane& in, const std::vector<int>& to, int y, int x, int c) {
  const auto source = [](int at, int from, int size) { return std::max(0.0, (at + 0.5) * from / size - 0.5); };
  const double sy = source(y, in.shape[1], to[1]);
  const double sx = source(x, in.shape[2], to[2]);
  const int y0 = std::min(int(sy), in.shape[1] - 1);
  const int x0 = std::min(int(sx), in.shape[2] - 1);
  const int y1 = std::min(y0 + 1, in.shape[1] - 1);
  const int x1 = std::min(x0 + 1, in.shape[2] - 1);
  const double fy = sy - y0;
  const double fx = sx - x0;
  return (1 - fy) * ((1 - fx) * in.get(y0, x0, c) + fx * in.get(y0, x1, c)) +
         fy * ((1 - fx) * in.get(y1, x0, c) + fx * in.get(y1, x1, c));
}

Plane computed(const NetworkGraph& graph, const NetworkNode& node, const std::vector<Plane>& known) {
  const auto input = [&](std::size_t k) -> const Plane& { return known[std::size_t(node.inputs[k])]; };
  const Plane& in = input(0);
  Plane out(graph.tensors[std::size_t(node.output)].shape);
  const auto clamped = [&](double x) { return std::clamp(x, double(node.least), double(node.most)); };
  switch (node.operation) {
    case NetworkOperation::kReshape:
      out.numbers = in.numbers;
      return out;
    case NetworkOperation::kSigmoid:
      for (std::size_t k = 0; k < in.numbers.size(); ++k) out.numbers[k] = 1 / (1 + std::exp(-in.numbers[k]));
      return out;
    case NetworkOperation::kClamp:
      for (std::size_t k = 0; k < in.numbers.size(); ++k) out.numbers[k] = clamped(in.numbers[k]);
      return out;
    case NetworkOperation::kAdd:
      for (std::size_t k = 0; k < in.numbers.size(); ++k) {
        out.numbers[k] = clamped(in.numbers[k] + input(1).numbers[k]);
      }
      return out;
    default:
      break;
  }
  for (int y = 0; y < out.shape[1]; ++y) {
    for (int x = 0; x < out.shape[2]; ++x) {
      for (int c = 0; c < out.shape[3]; ++c) {
        const int top = y * node.stride.y - node.margin.top;
        const int left = x * node.stride.x - node.margin.left;
        double value = 0;
        switch (node.operation) {
          case NetworkOperation::kConvolution:
          case NetworkOperation::kDepthwise: {
            const bool each = node.operation == NetworkOperation::kDepthwise;
            const auto& weights = input(1).numbers;
            value = input(2).numbers[std::size_t(c)];
            const int channels = each ? 1 : in.shape[3];
            std::size_t w = each ? std::size_t(c) : std::size_t(c * node.kernel.y * node.kernel.x * channels);
            for (int ky = 0; ky < node.kernel.y; ++ky) {
              for (int kx = 0; kx < node.kernel.x; ++kx) {
                for (int i = 0; i < channels; ++i) {
                  value += weights[w] * in.get(top + ky, left + kx, each ? c : i);
                  w += each ? std::size_t(in.shape[3]) : 1;
                }
              }
            }
            value = clamped(value);
            break;
          }
          case NetworkOperation::kMaximum:
            value = -std::numeric_limits<double>::infinity();
            for (int ky = 0; ky < node.kernel.y; ++ky) {
              for (int kx = 0; kx < node.kernel.x; ++kx) {
                if (in.inside(top + ky, left + kx)) value = std::max(value, in.get(top + ky, left + kx, c));
              }
            }
            value = clamped(value);
            break;
          case NetworkOperation::kResizeBilinear:
            value = resized(in, out.shape, y, x, c);
            break;
          case NetworkOperation::kDepthToSpace: {
            const int b = node.block;
            value = in.get(y / b, x / b, (y % b * b + x % b) * out.shape[3] + c);
            break;
          }
          default:
            break;
        }
        out.at(y, x, c) = value;
      }
    }
  }
  return out;
}

}  // namespace

std::vector<std::vector<double>> evaluate(const NetworkGraph& graph, std::span<const float> input) {
  std::vector<Plane> known;
  for (const auto& tensor : graph.tensors) {
    known.emplace_back(tensor.shape);
    std::copy(tensor.constant.begin(), tensor.constant.end(), known.back().numbers.begin());
  }
  std::copy(input.begin(), input.end(), known[std::size_t(graph.input)].numbers.begin());
  for (const auto& node : graph.nodes) known[std::size_t(node.output)] = computed(graph, node, known);
  std::vector<std::vector<double>> outputs;
  for (const auto& output : graph.outputs) {
    auto& all = outputs.emplace_back();
    for (const int k : output.parts) {
      const auto& part = known[std::size_t(k)].numbers;
      all.insert(all.end(), part.begin(), part.end());
    }
  }
  return outputs;
}

}  // namespace choreo::test
