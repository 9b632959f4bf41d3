// SPDX-License-Identifier: Apache-2.0
#include "vision/network/tflite_reader.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <numeric>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include <tflite_generated.h>
#include "core/error.hpp"
#include "vision/network/sparse_weights.hpp"

namespace choreo::vision {
namespace {

constexpr std::size_t kMostNumbers = std::size_t{1} << 26U;  // In all tensors; the largest pose model has 2^25.
constexpr std::size_t kMostWork = std::size_t{1} << 34U;     // Multiplications; the largest pose model has 2^31.

[[noreturn]] void refuse(std::string_view what) { refuse_network(what); }

template <typename T>
auto items(const flatbuffers::Vector<T>* vector) {
  using Size = flatbuffers::uoffset_t;
  std::vector<typename flatbuffers::Vector<T>::return_type> all;
  if (vector != nullptr) {
    for (Size k = 0; k < vector->size(); ++k) all.push_back(vector->Get(k));
  }
  return all;
}

std::vector<int> sizes_of(const flatbuffers::Vector<std::int32_t>* shape) {
  auto sizes = items(shape);
  std::size_t count = 1;
  for (const int size : sizes) {
    if (size < 1 || std::size_t(size) > kMostNumbers / count) refuse("has a tensor of an impossible size");
    count *= std::size_t(size);
  }
  if (sizes.empty() || sizes.size() > 4) refuse("has a tensor that has not one to four dimensions");
  return sizes;
}

std::vector<int> indices_of(tflite::SparseIndexVector type, const void* vector) {
  const auto ints = [](const auto* table) {
    std::vector<int> all;
    if (table->values() != nullptr) all.assign(table->values()->begin(), table->values()->end());
    return all;
  };
  if (vector == nullptr) refuse("has sparse weights without indices");
  switch (type) {
    case tflite::SparseIndexVector::Int32Vector:
      return ints(static_cast<const tflite::Int32Vector*>(vector));
    case tflite::SparseIndexVector::Uint16Vector:
      return ints(static_cast<const tflite::Uint16Vector*>(vector));
    case tflite::SparseIndexVector::Uint8Vector:
      return ints(static_cast<const tflite::Uint8Vector*>(vector));
    default:
      refuse("has sparse weights without indices");
  }
}

std::vector<SparseLevel> levels_of(const tflite::SparsityParameters& sparsity, const std::vector<int>& shape) {
  const auto order = items(sparsity.traversal_order());
  const auto dimensions = items(sparsity.dim_metadata());
  if (sparsity.block_map() != nullptr && sparsity.block_map()->size() != 0) refuse("has sparse weights in blocks");
  if (dimensions.size() != shape.size() || order.size() != shape.size()) refuse("has sparse weights of an odd shape");
  std::vector<SparseLevel> levels;
  for (std::size_t k = 0; k < shape.size(); ++k) {
    const auto* dimension = dimensions[k];
    if (order[k] != int(k) || dimension == nullptr) refuse("has sparse weights in an odd order");
    SparseLevel level;
    level.sparse = dimension->format() == tflite::DimensionType::SPARSE_CSR;
    if (level.sparse) {
      level.segments = indices_of(dimension->array_segments_type(), dimension->array_segments());
      level.indices = indices_of(dimension->array_indices_type(), dimension->array_indices());
    } else if (dimension->dense_size() != shape[k]) {
      refuse("has sparse weights of an odd shape");
    }
    levels.push_back(std::move(level));
  }
  return levels;
}

std::vector<float> floats_of(std::span<const std::uint8_t> bytes, tflite::TensorType type) {
  const std::size_t each = type == tflite::TensorType::FLOAT16 ? 2 : 4;
  if (bytes.size() % each != 0 || bytes.size() / each > kMostNumbers) refuse("has weights of an odd length");
  std::vector<float> numbers(bytes.size() / each);
  if (type == tflite::TensorType::FLOAT32) {
    std::memcpy(numbers.data(), bytes.data(), bytes.size());
  } else if (type == tflite::TensorType::INT32) {
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      std::int32_t number = 0;
      std::memcpy(&number, bytes.data() + 4 * k, 4);
      numbers[k] = float(number);
    }
  } else {
    cv::Mat halves(1, int(numbers.size()), CV_16FC1);
    std::memcpy(halves.data, bytes.data(), bytes.size());
    cv::Mat singles(1, int(numbers.size()), CV_32FC1, numbers.data());
    halves.convertTo(singles, CV_32F);
  }
  if (!std::ranges::all_of(numbers, [](float x) { return std::isfinite(x); }))
    refuse("has weights that are no numbers");
  return numbers;
}

// Zeros before and behind where the output is as large as the input over the stride: TensorFlow's SAME.
void same_margin(int size, int kernel, int stride, int& before, int& behind) {
  const int windows = (size + stride - 1) / stride;
  const int all = std::max((windows - 1) * stride + kernel - size, 0);
  before = all / 2;
  behind = all - before;
}

class Reader {
 public:
  explicit Reader(const tflite::Model& model) : model_(model) {
    const auto graphs = items(model.subgraphs());
    if (graphs.size() != 1 || graphs[0] == nullptr) refuse("has not one graph");
    const auto& graph = *graphs[0];
    codes_ = items(model.operator_codes());
    read_tensors(graph);
    const auto inputs = items(graph.inputs());
    if (inputs.size() != 1) refuse("has not one input");
    out_.input = checked(inputs[0]);
    const auto& input = tensor(out_.input);
    if (input.shape.size() != 4 || input.shape[0] != 1 || !input.constant.empty()) refuse("does not take one picture");
    known_[std::size_t(out_.input)] = true;
    for (const auto* node : items(graph.operators())) read_node(node);
    constexpr std::size_t kMostOutputs = 16;
    for (const int k : items(graph.outputs())) {
      if (out_.outputs.size() == kMostOutputs) refuse("has too many outputs");
      if (!known_[std::size_t(checked(k))] || !tensor(k).constant.empty() || padded_.contains(k)) {
        refuse("has an output that nothing computes");
      }
      const auto parts = joined_.find(k);
      out_.outputs.push_back({parts == joined_.end() ? std::vector{k} : parts->second, tensor(k).shape});
    }
    if (out_.outputs.empty()) refuse("has no output");
  }

  [[nodiscard]] NetworkGraph take() { return std::move(out_); }

 private:
  int checked(int k) const {
    if (k < 0 || std::size_t(k) >= out_.tensors.size()) refuse("names a tensor that is not there");
    return k;
  }
  NetworkTensor& tensor(int k) { return out_.tensors[std::size_t(checked(k))]; }

  void read_tensors(const tflite::SubGraph& graph) {
    const auto buffers = items(model_.buffers());
    for (const auto* t : items(graph.tensors())) {
      if (t == nullptr) refuse("has a tensor that is not there");
      NetworkTensor tensor;
      tensor.shape = sizes_of(t->shape());
      take(numbers_, tensor.count(), kMostNumbers, "has more numbers than memory holds");
      const auto type = t->type();
      const bool readable = type == tflite::TensorType::FLOAT32 || type == tflite::TensorType::FLOAT16 ||
                            type == tflite::TensorType::INT32;
      if (!readable) refuse(fmt::format("has a tensor of type {}; 16- and 32-bit floats are read", int(type)));
      if (t->buffer() >= buffers.size() || buffers[t->buffer()] == nullptr) refuse("has a tensor without a place");
      const auto* data = buffers[t->buffer()]->data();
      if (data != nullptr && data->size() != 0) {
        tensor.constant = floats_of({data->data(), data->size()}, type);
        // What makes it dense is a node of its own.
        if (t->sparsity() != nullptr) {
          tensor.constant = dense_weights(levels_of(*t->sparsity(), tensor.shape), tensor.shape, tensor.constant);
        }
        if (tensor.constant.size() != tensor.count()) refuse("has weights of another number than their shape says");
      } else if (type == tflite::TensorType::INT32) {
        refuse("computes with whole numbers");
      }
      known_.push_back(!tensor.constant.empty());
      out_.tensors.push_back(std::move(tensor));
    }
  }

  template <typename Options>
  static const Options& options_of(const Options* options) {
    if (options == nullptr) refuse("has an operation without its settings");
    return *options;
  }

  static void set_activation(NetworkNode& node, tflite::Activation activation) {
    switch (activation) {
      case tflite::Activation::NONE:
        return;
      case tflite::Activation::RELU:
        node.least = 0;
        return;
      case tflite::Activation::RELU6:
        node.least = 0;
        node.most = 6;
        return;
      case tflite::Activation::RELU_N1_TO_1:
        node.least = -1;
        node.most = 1;
        return;
    }
    refuse(fmt::format("has an activation of kind {}", int(activation)));
  }

  // How windows lie, and how many of them there are.
  template <typename Options>
  std::vector<int> windows(NetworkNode& node, const Options& options, const std::vector<int>& in, int channels) const {
    constexpr int kMostStride = 64;
    const int sy = options.stride_h();
    const int sx = options.stride_w();
    if (sy < 1 || sx < 1 || sy > kMostStride || sx > kMostStride) refuse("has a stride of no pixel");
    node.stride = {sy, sx};
    auto& m = node.margin;
    if (options.padding() == tflite::Padding::SAME) {
      same_margin(in[1], node.kernel.y, sy, m.top, m.bottom);
      same_margin(in[2], node.kernel.x, sx, m.left, m.right);
    } else if (options.padding() != tflite::Padding::VALID) {
      refuse("has a padding of an unknown kind");
    }
    const int high = in[1] + m.top + m.bottom - node.kernel.y;
    const int wide = in[2] + m.left + m.right - node.kernel.x;
    if (high < 0 || wide < 0) refuse("has a window larger than its picture");
    set_activation(node, options.activation());
    return {1, high / sy + 1, wide / sx + 1, channels};
  }

  void require_weights(const NetworkNode& node, const std::vector<int>& weights, int bias) {
    if (node.inputs.size() != 3 || tensor(node.inputs[1]).constant.empty() || tensor(node.inputs[2]).constant.empty()) {
      refuse("has a convolution without weights and bias");
    }
    if (tensor(node.inputs[1]).shape != weights || tensor(node.inputs[2]).shape != std::vector{bias}) {
      refuse("has weights of an odd shape");
    }
  }

  const std::vector<int>& picture(const NetworkNode& node) {
    const auto& shape = tensor(node.inputs.at(0)).shape;
    if (shape.size() != 4 || shape[0] != 1) refuse("looks for a picture in what is none");
    return shape;
  }

  void require_shape(int output, const std::vector<int>& shape) {
    if (shape != tensor(output).shape) refuse("has an operation that makes another shape than it says");
  }

  // Zeros around a picture are the margin of the convolution that reads it.
  void take_margin(NetworkNode& node) {
    for (std::size_t k = 0; k < node.inputs.size(); ++k) {
      const auto found = padded_.find(node.inputs[k]);
      if (found == padded_.end()) continue;
      if (k != 0 ||
          (node.operation != NetworkOperation::kConvolution && node.operation != NetworkOperation::kDepthwise)) {
        refuse("pads what is not convolved");
      }
      const auto& [picture, margin] = found->second;
      node.inputs[0] = picture;
      node.margin.top += margin.top;
      node.margin.bottom += margin.bottom;
      node.margin.left += margin.left;
      node.margin.right += margin.right;
    }
  }

  // Results that follow each other; nothing else may read them.
  void join(const tflite::ConcatenationOptions& options, const NetworkNode& node) {
    if (node.inputs.empty()) refuse("joins nothing");
    auto shape = tensor(node.inputs[0]).shape;
    const int axis = options.axis() < 0 ? options.axis() + int(shape.size()) : options.axis();
    if (axis < 0 || axis >= int(shape.size()) || options.activation() != tflite::Activation::NONE ||
        std::any_of(shape.begin(), shape.begin() + axis, [](int size) { return size != 1; })) {
      refuse("joins what does not follow each other");
    }
    const auto at = std::size_t(axis);
    shape[at] = 0;
    for (const int k : node.inputs) {
      auto other = tensor(k).shape;
      if (other.size() != shape.size() || !tensor(k).constant.empty() || padded_.contains(k)) {
        refuse("joins what does not fit together");
      }
      if (std::size_t(shape[at]) + std::size_t(other[at]) > kMostNumbers) refuse("joins more than memory holds");
      shape[at] += other[at];
      other[at] = shape[at];
      if (other != shape) refuse("joins what does not fit together");
    }
    require_shape(node.output, shape);
    joined_[node.output] = node.inputs;
  }

  // Fills `node` in. @return the shape that it makes; empty where there is nothing left to compute.
  std::vector<int> understand(tflite::BuiltinOperator code, const tflite::Operator& op, NetworkNode& node) {
    const auto inputs_are = [&](std::size_t count) {
      if (node.inputs.size() != count) refuse("has an operation with an odd number of inputs");
    };
    switch (code) {
      case tflite::BuiltinOperator::DEQUANTIZE:
      case tflite::BuiltinOperator::DENSIFY: {
        inputs_are(1);
        const auto& in = tensor(node.inputs[0]);
        if (in.constant.empty()) refuse("changes the precision of what it computes");
        if (in.shape != tensor(node.output).shape) refuse("has an operation of odd shapes");
        tensor(node.output).constant = in.constant;
        return {};
      }
      case tflite::BuiltinOperator::CONV_2D: {
        const auto& options = options_of(op.options_as_Conv2DOptions());
        if (options.dilation_h_factor() != 1 || options.dilation_w_factor() != 1) refuse("has holes in a window");
        inputs_are(3);
        const auto& in = picture(node);
        const auto weights = tensor(node.inputs[1]).shape;
        if (weights.size() != 4) refuse("has weights of an odd shape");
        require_weights(node, {weights[0], weights[1], weights[2], in[3]}, weights[0]);
        node.operation = NetworkOperation::kConvolution;
        node.kernel = {weights[1], weights[2]};
        return windows(node, options, in, weights[0]);
      }
      case tflite::BuiltinOperator::DEPTHWISE_CONV_2D: {
        const auto& options = options_of(op.options_as_DepthwiseConv2DOptions());
        if (options.dilation_h_factor() != 1 || options.dilation_w_factor() != 1) refuse("has holes in a window");
        inputs_are(3);
        const auto& in = picture(node);
        const auto weights = tensor(node.inputs[1]).shape;
        if (weights.size() != 4) refuse("has weights of an odd shape");
        require_weights(node, {1, weights[1], weights[2], in[3]}, in[3]);
        node.operation = NetworkOperation::kDepthwise;
        node.kernel = {weights[1], weights[2]};
        return windows(node, options, in, in[3]);
      }
      case tflite::BuiltinOperator::MAX_POOL_2D: {
        const auto& options = options_of(op.options_as_Pool2DOptions());
        inputs_are(1);
        const auto& in = picture(node);
        node.operation = NetworkOperation::kMaximum;
        node.kernel = {options.filter_height(), options.filter_width()};
        if (node.kernel.y < 1 || node.kernel.x < 1 || node.kernel.y > in[1] || node.kernel.x > in[2]) {
          refuse("has a window of an odd size");
        }
        if (options.activation() != tflite::Activation::NONE) refuse("has an activation behind maxima");
        return windows(node, options, in, in[3]);
      }
      case tflite::BuiltinOperator::ADD: {
        inputs_are(2);
        if (tensor(node.inputs[0]).shape != tensor(node.inputs[1]).shape) refuse("adds what is of two shapes");
        node.operation = NetworkOperation::kAdd;
        if (const auto* options = op.options_as_AddOptions()) set_activation(node, options->activation());
        return tensor(node.inputs[0]).shape;
      }
      case tflite::BuiltinOperator::PAD: {
        inputs_are(2);
        const auto& in = picture(node);
        const auto& by = tensor(node.inputs[1]);
        if (by.shape != std::vector{4, 2} || by.constant.empty()) refuse("has a margin of an odd shape");
        std::array<int, 8> m{};
        constexpr float kMost = 4096;
        for (std::size_t k = 0; k < m.size(); ++k) {
          if (by.constant[k] < 0 || by.constant[k] > kMost) refuse("has a margin of an odd size");
          m[k] = int(by.constant[k]);
        }
        if (m[0] != 0 || m[1] != 0 || m[6] != 0 || m[7] != 0) refuse("has a margin on an odd side");
        if (padded_.contains(node.inputs[0])) refuse("pads twice");
        padded_[node.output] = {node.inputs[0], {m[2], m[3], m[4], m[5]}};
        require_shape(node.output, {1, in[1] + m[2] + m[3], in[2] + m[4] + m[5], in[3]});
        return {};
      }
      case tflite::BuiltinOperator::RESIZE_BILINEAR: {
        const auto& options = options_of(op.options_as_ResizeBilinearOptions());
        inputs_are(2);
        const auto& in = picture(node);
        const auto& to = tensor(node.inputs[1]);
        const auto& made = tensor(node.output).shape;
        if (to.constant.size() != 2 || made.size() != 4 || to.constant[0] != float(made[1]) ||
            to.constant[1] != float(made[2])) {
          refuse("resizes to an odd size");
        }
        if (options.align_corners() || !options.half_pixel_centers()) refuse("resizes in another way than by squares");
        node.operation = NetworkOperation::kResizeBilinear;
        node.inputs.erase(node.inputs.begin() + 1, node.inputs.end());
        return {1, made[1], made[2], in[3]};
      }
      case tflite::BuiltinOperator::RESHAPE: {
        if (node.inputs.empty() || node.inputs.size() > 2) refuse("has an operation with an odd number of inputs");
        node.inputs.erase(node.inputs.begin() + 1, node.inputs.end());
        node.operation = NetworkOperation::kReshape;
        if (tensor(node.inputs[0]).count() != tensor(node.output).count()) refuse("reshapes to another number");
        return tensor(node.output).shape;
      }
      case tflite::BuiltinOperator::DEPTH_TO_SPACE: {
        inputs_are(1);
        const auto& in = picture(node);
        const auto& made = tensor(node.output).shape;
        node.operation = NetworkOperation::kDepthToSpace;
        constexpr int kMostBlock = 64;
        node.block = made.size() == 4 ? made[1] / in[1] : 0;
        if (node.block < 2 || node.block > kMostBlock || in[3] % (node.block * node.block) != 0) {
          refuse("spreads channels over an odd square");
        }
        return {1, in[1] * node.block, in[2] * node.block, in[3] / (node.block * node.block)};
      }
      case tflite::BuiltinOperator::CONCATENATION:
        join(options_of(op.options_as_ConcatenationOptions()), node);
        return {};
      case tflite::BuiltinOperator::LOGISTIC:
        inputs_are(1);
        node.operation = NetworkOperation::kSigmoid;
        return tensor(node.inputs[0]).shape;
      case tflite::BuiltinOperator::RELU:
        inputs_are(1);
        node.operation = NetworkOperation::kClamp;
        node.least = 0;
        return tensor(node.inputs[0]).shape;
    }
    refuse(fmt::format("has an operation of kind {}, which is none of a pose model", int(code)));
  }

  // Counts what there is of something, up to what there may be.
  static void take(std::size_t& sum, std::size_t more, std::size_t most, const char* words) {
    if (more > most - sum) refuse(words);
    sum += more;
  }

  // Multiplications of a node.
  std::size_t work_of(const NetworkNode& node) {
    std::size_t work = tensor(node.output).count();
    if (node.operation == NetworkOperation::kReshape) return work;
    work *= std::size_t(node.kernel.y) * std::size_t(node.kernel.x);
    return node.operation == NetworkOperation::kConvolution ? work * std::size_t(tensor(node.inputs[0]).shape[3])
                                                            : work;
  }

  void read_node(const tflite::Operator* op) {
    if (op == nullptr || op->opcode_index() >= codes_.size() || codes_[op->opcode_index()] == nullptr) {
      refuse("has an operation that is not there");
    }
    const auto* code = codes_[op->opcode_index()];
    NetworkNode node;
    for (const int k : items(op->inputs())) {
      if (!known_[std::size_t(checked(k))]) refuse("computes with what is not computed yet");
      if (joined_.contains(k)) refuse("computes with what it joined");
      node.inputs.push_back(k);
    }
    const auto outputs = items(op->outputs());
    if (outputs.size() != 1) refuse("has an operation with several results");
    node.output = checked(outputs[0]);
    if (known_[std::size_t(node.output)]) refuse("computes the same twice");
    // The number moved when there were more than a byte holds.
    const auto number =
        static_cast<tflite::BuiltinOperator>(std::max(int(code->deprecated_builtin_code()), int(code->builtin_code())));
    const auto shape = understand(number, *op, node);
    known_[std::size_t(node.output)] = true;
    if (shape.empty()) return;
    require_shape(node.output, shape);
    const std::size_t computed = node.operation == NetworkOperation::kAdd ? 2 : 1;
    for (std::size_t k = 0; k < computed; ++k) {
      if (!tensor(node.inputs[k]).constant.empty()) refuse("computes with what is constant");
    }
    take_margin(node);
    take(work_, work_of(node), kMostWork, "has more to compute than can be waited for");
    out_.nodes.push_back(std::move(node));
  }

  const tflite::Model& model_;
  NetworkGraph out_;
  std::vector<bool> known_;  // Of each tensor: whether it is constant, given or computed.
  std::vector<const tflite::OperatorCode*> codes_;
  std::size_t numbers_ = 0, work_ = 0;
  std::map<int, std::vector<int>> joined_;
  std::map<int, std::pair<int, PixelMargin>> padded_;
};

}  // namespace

std::size_t NetworkTensor::count() const {
  return std::accumulate(shape.begin(), shape.end(), std::size_t{1},
                         [](std::size_t product, int size) { return product * std::size_t(size); });
}

NetworkGraph read_tflite(std::span<const std::uint8_t> file) {
  constexpr flatbuffers::uoffset_t kDepth = 64;
  constexpr flatbuffers::uoffset_t kTables = 1'000'000;
  constexpr std::size_t kLeast = 8;  // The root's offset and the name of the format.
  // Of memory as it is allocated, so that what is aligned in the file is aligned here.
  const std::vector<std::uint8_t> bytes(file.begin(), file.end());
  flatbuffers::Verifier verifier(bytes.data(), bytes.size(), kDepth, kTables);
  if (bytes.size() < kLeast || !tflite::ModelBufferHasIdentifier(bytes.data()) ||
      !tflite::VerifyModelBuffer(verifier)) {
    refuse("is damaged, or no TensorFlow Lite file");
  }
  return Reader(*tflite::GetModel(bytes.data())).take();
}

}  // namespace choreo::vision
