// SPDX-License-Identifier: Apache-2.0
#include "vision/network/network.hpp"

#include <map>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>
#include <dnnl.hpp>

#include "core/error.hpp"

// Of OpenMP 5.0, 3.2: oneDNN has no other way to be told. Its header is the compiler's, and clang has none of gcc's.
extern "C" {
int omp_get_max_threads();
void omp_set_num_threads(int threads);
}

namespace choreo::vision {
namespace {

using dnnl::memory;
constexpr auto kFloat = memory::data_type::f32;
constexpr auto kInference = dnnl::prop_kind::forward_inference;

memory::dims dims_of(const std::vector<int>& shape) { return {shape.begin(), shape.end()}; }

// oneDNN numbers the dimensions of a picture 1, channels, height, width, however they lie in memory.
memory::dims picture_dims(const std::vector<int>& shape) { return {shape[0], shape[3], shape[1], shape[2]}; }

// As TensorFlow has it in memory: the last index fastest.
memory::desc plain(const std::vector<int>& shape) {
  if (shape.size() == 4) return {picture_dims(shape), kFloat, memory::format_tag::nhwc};
  constexpr memory::format_tag kTags[] = {memory::format_tag::a, memory::format_tag::ab, memory::format_tag::abc};
  return {dims_of(shape), kFloat, kTags[shape.size() - 1]};
}

// Whatever layout suits the operation.
memory::desc any(const std::vector<int>& shape) { return {picture_dims(shape), kFloat, memory::format_tag::any}; }

bool has_limits(const NetworkNode& node) {
  return node.least > -std::numeric_limits<float>::max() || node.most < std::numeric_limits<float>::max();
}

std::pair<float, float> limits(const NetworkNode& node) {
  constexpr float kMost = std::numeric_limits<float>::max();
  return {std::max(node.least, -kMost), std::min(node.most, kMost)};
}

dnnl::primitive_attr with_limits(const NetworkNode& node) {
  dnnl::primitive_attr attributes;
  if (!has_limits(node)) return attributes;
  dnnl::post_ops after;
  const auto [least, most] = limits(node);
  after.append_eltwise(1.0F, dnnl::algorithm::eltwise_clip, least, most);
  attributes.set_post_ops(after);
  return attributes;
}

// OpenMP takes the caller's thread alone while this lives; the setting is that thread's own. Several would wait for
// each other after every operation, by turning round: beside another program on the same cores each wait can take a
// time slice, and a look a hundred times as long.
class OneThread {
 public:
  OneThread() : before_(omp_get_max_threads()) { omp_set_num_threads(1); }
  ~OneThread() { omp_set_num_threads(before_); }
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  int before_;
};

}  // namespace

class Network::Impl {
 public:
  explicit Impl(const NetworkGraph& graph) : graph_(graph), engine_(dnnl::engine::kind::cpu, 0), stream_(engine_) {
    const OneThread limit;
    const auto& input = tensor(graph.input);
    input_shape_ = input.shape;
    input_.resize(input.count());
    places_.emplace(graph.input, memory(plain(input.shape), engine_, input_.data()));
    for (const auto& node : graph.nodes) add(node);
    for (const auto& output : graph.outputs) {
      std::size_t count = 0;
      for (const int k : output.parts) count += tensor(k).count();
      output_shapes_.push_back(output.shape);
      float* to = outputs_.emplace_back(count).data();
      for (const int k : output.parts) {
        reorder(place(k), memory(plain(tensor(k).shape), engine_, to));
        to += tensor(k).count();
      }
    }
    stream_.wait();
    graph_ = {};  // The weights are where they are needed.
    places_.clear();
  }

  void run() {
    const OneThread limit;
    for (auto& step : steps_) step.primitive.execute(stream_, step.arguments);
    stream_.wait();
  }

  std::vector<int> input_shape_;
  std::vector<std::vector<int>> output_shapes_;
  std::vector<float> input_;
  std::vector<std::vector<float>> outputs_;

 private:
  struct Step {
    dnnl::primitive primitive;
    std::unordered_map<int, memory> arguments;
  };

  [[nodiscard]] const NetworkTensor& tensor(int k) const { return graph_.tensors[std::size_t(k)]; }
  [[nodiscard]] const memory& place(int k) const { return places_.at(k); }

  void reorder(const memory& from, const memory& to) {
    steps_.push_back({dnnl::reorder(from, to), {{DNNL_ARG_FROM, from}, {DNNL_ARG_TO, to}}});
  }
  // Tensor `k` in that layout.
  memory arranged(int k, const memory::desc& wanted) {
    const auto& now = place(k);
    if (now.get_desc() == wanted) return now;
    memory then(wanted, engine_);
    reorder(now, then);
    return then;
  }
  // A constant in the layout that an operation wants; once.
  memory constant(int k, const memory::desc& given, const memory::desc& wanted) {
    auto numbers = tensor(k).constant;
    memory from(given, engine_, numbers.data());
    memory to(wanted, engine_);
    dnnl::reorder(from, to).execute(stream_, from, to);
    stream_.wait();
    return to;
  }

  void add(const NetworkNode& node) {
    const int in = node.inputs[0];
    const auto& taken = tensor(in).shape;
    const auto& made = tensor(node.output).shape;
    memory out;
    switch (node.operation) {
      case NetworkOperation::kConvolution:
      case NetworkOperation::kDepthwise:
        out = convolution(node, taken, made);
        break;
      case NetworkOperation::kAdd: {
        const auto& first = place(in);
        const auto second = arranged(node.inputs[1], first.get_desc());
        const dnnl::binary::primitive_desc sum(
            {dnnl::algorithm::binary_add, first.get_desc(), second.get_desc(), first.get_desc()}, with_limits(node),
            engine_);
        out = memory(sum.dst_desc(), engine_);
        steps_.push_back({dnnl::binary(sum), {{DNNL_ARG_SRC_0, first}, {DNNL_ARG_SRC_1, second}, {DNNL_ARG_DST, out}}});
        break;
      }
      case NetworkOperation::kMaximum: {
        const auto& from = place(in);
        const dnnl::pooling_forward::primitive_desc maximum(
            {kInference, dnnl::algorithm::pooling_max, from.get_desc(), any(made), stride(node), kernel(node),
             upper_left(node), lower_right(node)},
            engine_);
        out = memory(maximum.dst_desc(), engine_);
        steps_.push_back({dnnl::pooling_forward(maximum), {{DNNL_ARG_SRC, from}, {DNNL_ARG_DST, out}}});
        break;
      }
      case NetworkOperation::kResizeBilinear: {
        const auto& from = place(in);
        const dnnl::resampling_forward::primitive_desc resize(
            {kInference, dnnl::algorithm::resampling_linear, from.get_desc(), any(made)}, engine_);
        out = memory(resize.dst_desc(), engine_);
        steps_.push_back({dnnl::resampling_forward(resize), {{DNNL_ARG_SRC, from}, {DNNL_ARG_DST, out}}});
        break;
      }
      case NetworkOperation::kReshape: {
        const auto from = arranged(in, plain(taken));
        kept_.push_back(from);
        out = memory(plain(made), engine_, from.get_data_handle());
        break;
      }
      case NetworkOperation::kDepthToSpace: {
        // Indices row, column, row and column in the square, channel: only their order in memory changes.
        const memory::dim b = node.block;
        const memory::dim w = taken[2];
        const memory::dim c = made[3];
        const memory::dims sizes = {taken[1], w, b, b, c};
        const auto from = arranged(in, plain(taken));
        out = memory(plain(made), engine_);
        kept_.push_back(from);
        reorder(memory({sizes, kFloat, {w * b * b * c, b * b * c, b * c, c, 1}}, engine_, from.get_data_handle()),
                memory({sizes, kFloat, {b * w * b * c, b * c, w * b * c, c, 1}}, engine_, out.get_data_handle()));
        kept_.push_back(out);
        break;
      }
      case NetworkOperation::kSigmoid:
      case NetworkOperation::kClamp: {
        const auto& from = place(in);
        const auto [least, most] = limits(node);
        const bool clamp = node.operation == NetworkOperation::kClamp;
        const dnnl::eltwise_forward::primitive_desc each(
            {kInference, clamp ? dnnl::algorithm::eltwise_clip : dnnl::algorithm::eltwise_logistic, from.get_desc(),
             least, most},
            engine_);
        out = memory(each.dst_desc(), engine_);
        steps_.push_back({dnnl::eltwise_forward(each), {{DNNL_ARG_SRC, from}, {DNNL_ARG_DST, out}}});
        break;
      }
    }
    places_.emplace(node.output, out);
  }

  memory convolution(const NetworkNode& node, const std::vector<int>& taken, const std::vector<int>& made) {
    const memory::dim h = node.kernel.y;
    const memory::dim w = node.kernel.x;
    const memory::dim from = taken[3];
    const memory::dim to = made[3];
    const bool each = node.operation == NetworkOperation::kDepthwise;
    // Groups first where every channel is one.
    const memory::dims sizes = each ? memory::dims{to, 1, 1, h, w} : memory::dims{to, from, h, w};
    const memory::dims strides =
        each ? memory::dims{1, 1, 1, w * to, to} : memory::dims{h * w * from, 1, w * from, from};
    const memory::desc bias({to}, kFloat, memory::format_tag::x);
    const dnnl::convolution_forward::primitive_desc convolution({kInference,
                                                                 dnnl::algorithm::convolution_auto,
                                                                 any(taken),
                                                                 {sizes, kFloat, memory::format_tag::any},
                                                                 bias,
                                                                 any(made),
                                                                 stride(node),
                                                                 upper_left(node),
                                                                 lower_right(node)},
                                                                with_limits(node), engine_);
    memory out(convolution.dst_desc(), engine_);
    steps_.push_back(
        {dnnl::convolution_forward(convolution),
         {{DNNL_ARG_SRC, arranged(node.inputs[0], convolution.src_desc())},
          {DNNL_ARG_WEIGHTS, constant(node.inputs[1], {sizes, kFloat, strides}, convolution.weights_desc())},
          {DNNL_ARG_BIAS, constant(node.inputs[2], bias, bias)},
          {DNNL_ARG_DST, out}}});
    return out;
  }

  static memory::dims stride(const NetworkNode& node) { return {node.stride.y, node.stride.x}; }
  static memory::dims kernel(const NetworkNode& node) { return {node.kernel.y, node.kernel.x}; }
  static memory::dims upper_left(const NetworkNode& node) { return {node.margin.top, node.margin.left}; }
  static memory::dims lower_right(const NetworkNode& node) { return {node.margin.bottom, node.margin.right}; }

  NetworkGraph graph_;  // While it is translated.
  dnnl::engine engine_;
  dnnl::stream stream_;
  std::map<int, memory> places_;  // Of the tensors that are known so far.
  std::vector<memory> kept_;      // What is known under another shape as well.
  std::vector<Step> steps_;
};

Network::Network(const NetworkGraph& graph) try : impl_(std::make_unique<Impl>(graph)) {
} catch (const dnnl::error& error) {
  throw failure(fmt::format("the network cannot be prepared: {}", error.what()));
}

Network::~Network() = default;
Network::Network(Network&&) noexcept = default;
Network& Network::operator=(Network&&) noexcept = default;

void Network::run() {
  try {
    impl_->run();
  } catch (const dnnl::error& error) {
    throw failure(fmt::format("the network cannot be run: {}", error.what()));
  }
}

const std::vector<int>& Network::input_shape() const { return impl_->input_shape_; }
std::span<float> Network::input() { return impl_->input_; }
std::size_t Network::outputs() const { return impl_->outputs_.size(); }
const std::vector<int>& Network::output_shape(std::size_t k) const { return impl_->output_shapes_.at(k); }
std::span<const float> Network::output(std::size_t k) const { return impl_->outputs_.at(k); }

}  // namespace choreo::vision
