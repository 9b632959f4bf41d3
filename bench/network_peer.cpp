// SPDX-License-Identifier: Apache-2.0
#include "network_peer.hpp"

#include <cassert>
#include <cfloat>
#include <cstring>
#include <map>
#include <string>

namespace choreo::bench {
namespace {

using vision::NetworkGraph;
using vision::NetworkNode;
using vision::NetworkOperation;
using vision::NetworkTensor;
using Layer = cv::dnn::LayerParams;

// TensorFlow's order out, height, width, in (or 1, height, width, channels) becomes out, in, height, width.
cv::Mat weights_of(const NetworkTensor& tensor, bool each) {
  const auto& s = tensor.shape;
  const int out = each ? s[3] : s[0];
  const int in = each ? 1 : s[3];
  const int sizes[] = {out, in, s[1], s[2]};
  cv::Mat weights(4, sizes, CV_32F);
  auto* to = weights.ptr<float>();
  for (int o = 0; o < out; ++o) {
    for (int i = 0; i < in; ++i) {
      for (int y = 0; y < s[1]; ++y) {
        for (int x = 0; x < s[2]; ++x) {
          const int at = each ? (y * s[2] + x) * out + o : ((o * s[1] + y) * s[2] + x) * in + i;
          *to++ = tensor.constant[std::size_t(at)];
        }
      }
    }
  }
  return weights;
}

class Translation {
 public:
  Translation(const NetworkGraph& graph, cv::dnn::Net& net) : graph_(graph), net_(net) {
    net_.setInputsNames({"input"});
    layers_[graph.input] = 0;
    for (const auto& node : graph.nodes) add(node);
  }

  [[nodiscard]] cv::String name_of(int tensor) const { return names_.at(tensor); }

 private:
  [[nodiscard]] const NetworkTensor& tensor(int k) const { return graph_.tensors[std::size_t(k)]; }

  int layer(const char* type, Layer parameters, const std::vector<int>& from) {
    parameters.name = type + std::to_string(count_++);
    parameters.type = type;
    const int id = net_.addLayer(parameters.name, type, parameters);
    for (std::size_t k = 0; k < from.size(); ++k) net_.connect(from[k], 0, id, int(k));
    last_name_ = parameters.name;
    return id;
  }

  static void set_window(Layer& p, const NetworkNode& node) {
    p.set("kernel_h", node.kernel.y);
    p.set("kernel_w", node.kernel.x);
    p.set("stride_h", node.stride.y);
    p.set("stride_w", node.stride.x);
  }

  // OpenCV's windows have the same margin on both sides; another is a layer of its own.
  int padded(const NetworkNode& node, Layer& p, int from) {
    const auto& m = node.margin;
    if (m.top == m.bottom && m.left == m.right) {
      p.set("pad_h", m.top);
      p.set("pad_w", m.left);
      return from;
    }
    Layer pad;
    const int sizes[] = {0, 0, 0, 0, m.top, m.bottom, m.left, m.right};
    pad.set("paddings", cv::dnn::DictValue::arrayInt(sizes, 8));
    return layer("Padding", pad, {from});
  }

  int clamped(const NetworkNode& node, int from) {
    Layer p;
    if (node.most < FLT_MAX) {
      p.set("min_value", node.least);
      p.set("max_value", node.most);
      return layer("ReLU6", p, {from});
    }
    return node.least == 0 ? layer("ReLU", p, {from}) : from;
  }

  void add(const NetworkNode& node) {
    const int from = layers_.at(node.inputs[0]);
    const auto& made = tensor(node.output).shape;
    Layer p;
    int id = from;
    switch (node.operation) {
      case NetworkOperation::kConvolution:
      case NetworkOperation::kDepthwise: {
        const bool each = node.operation == NetworkOperation::kDepthwise;
        set_window(p, node);
        p.set("num_output", made[3]);
        p.set("group", each ? made[3] : 1);
        p.set("bias_term", true);
        p.blobs.push_back(weights_of(tensor(node.inputs[1]), each));
        auto bias = tensor(node.inputs[2]).constant;
        p.blobs.push_back(cv::Mat(1, made[3], CV_32F, bias.data()).clone());
        const int in = padded(node, p, from);
        id = clamped(node, layer("Convolution", p, {in}));
        break;
      }
      case NetworkOperation::kAdd:
        p.set("operation", "sum");
        id = clamped(node, layer("Eltwise", p, {from, layers_.at(node.inputs[1])}));
        break;
      case NetworkOperation::kMaximum:
        set_window(p, node);
        p.set("pool", "max");
        id = layer("Pooling", p, {from});
        break;
      case NetworkOperation::kResizeBilinear:
        p.set("interpolation", "opencv_linear");
        p.set("height", made[1]);
        p.set("width", made[2]);
        id = layer("Resize", p, {from});
        break;
      case NetworkOperation::kReshape:
        id = layer("Flatten", p, {from});
        break;
      case NetworkOperation::kSigmoid:
        id = layer("Sigmoid", p, {from});
        break;
      case NetworkOperation::kClamp:
        id = clamped(node, from);
        break;
      case NetworkOperation::kDepthToSpace:
        assert(false);
        break;
    }
    layers_[node.output] = id;
    names_[node.output] = last_name_;
  }

  const NetworkGraph& graph_;
  cv::dnn::Net& net_;
  std::map<int, int> layers_;  // By tensor.
  std::map<int, cv::String> names_;
  cv::String last_name_;
  int count_ = 0;
};

}  // namespace

PeerNetwork::PeerNetwork(const NetworkGraph& graph) {
  const Translation translation(graph, net);
  for (const auto& output : graph.outputs) outputs.push_back(translation.name_of(output.parts[0]));
  net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
}

}  // namespace choreo::bench
