// SPDX-License-Identifier: Apache-2.0
// A network gives what the definitions of its operations give, and a file that is not understood is refused.
#include "vision/network/network.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/error.hpp"
#include "vision/network/tflite_reader.hpp"
#include "vision/plain_network.hpp"
#include "vision/tiny_network.hpp"

namespace choreo::vision {
namespace {

using test::TinyNetwork;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using tflite::Activation;
using tflite::BuiltinOperator;
using tflite::Padding;

std::vector<float> random_numbers(std::size_t count, std::uint64_t seed) {
  std::vector<float> numbers(count);
  cv::Mat view(1, int(count), CV_32FC1, numbers.data());
  cv::RNG(seed).fill(view, cv::RNG::UNIFORM, -1, 1);
  return numbers;
}

std::vector<float> run(Network& network, const std::vector<float>& input, std::size_t k = 0) {
  std::copy(input.begin(), input.end(), network.input().begin());
  network.run();
  return {network.output(k).begin(), network.output(k).end()};
}

// Whatever its numbers, the network gives what the definitions give.
void expect_as_defined(const TinyNetwork& tiny) {
  const auto graph = read_tflite(tiny.file());
  const auto input = random_numbers(graph.tensors[std::size_t(graph.input)].count(), 7);
  const auto expected = test::evaluate(graph, input);
  Network network(graph);
  ASSERT_EQ(network.outputs(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k) {
    const auto given = run(network, input, k);
    ASSERT_EQ(given.size(), expected[k].size());
    for (std::size_t i = 0; i < given.size(); ++i) ASSERT_NEAR(given[i], expected[k][i], 1e-5) << "number " << i;
  }
}

tflite::Conv2DOptionsT convolution(Padding padding, int stride, Activation activation = Activation::NONE) {
  tflite::Conv2DOptionsT options;
  options.padding = padding;
  options.stride_h = options.stride_w = stride;
  options.activation = activation;
  return options;
}

TinyNetwork convolving(int size, int kernel, Padding padding, int stride, Activation activation = Activation::NONE) {
  TinyNetwork tiny;
  const int in = tiny.input({1, size, size + 1, 3});
  const int weights = tiny.floats({5, kernel, kernel, 3}, random_numbers(std::size_t(15 * kernel * kernel), 1));
  const int bias = tiny.floats({5}, random_numbers(5, 2));
  const auto windows = [&](int n) {
    return padding == Padding::SAME ? (n + stride - 1) / stride : (n - kernel) / stride + 1;
  };
  tiny.output(tiny.node(BuiltinOperator::CONV_2D, {in, weights, bias}, {1, windows(size), windows(size + 1), 5},
                        convolution(padding, stride, activation)));
  return tiny;
}

TEST(Network, ConvolvesAsDefined) {
  for (const int kernel : {1, 3, 5}) {
    for (const int stride : {1, 2}) {
      for (const auto padding : {Padding::SAME, Padding::VALID}) {
        for (const int size : {6, 7}) {
          SCOPED_TRACE(testing::Message() << kernel << " " << stride << " " << int(padding) << " " << size);
          expect_as_defined(convolving(size, kernel, padding, stride));
        }
      }
    }
  }
  for (const auto activation : {Activation::RELU, Activation::RELU6, Activation::RELU_N1_TO_1}) {
    expect_as_defined(convolving(5, 3, Padding::SAME, 1, activation));
  }
}

TEST(Network, AConvolutionByHand) {
  // Row 1 2 3 under the window 10 1 with zeros on the right only (SAME, even window), and 0.5 more.
  TinyNetwork tiny;
  const int in = tiny.input({1, 1, 3, 1});
  const int weights = tiny.floats({1, 1, 2, 1}, {10, 1});
  tiny.output(tiny.node(BuiltinOperator::CONV_2D, {in, weights, tiny.floats({1}, {0.5F})}, {1, 1, 3, 1},
                        convolution(Padding::SAME, 1)));
  Network network(read_tflite(tiny.file()));
  EXPECT_THAT(run(network, {1, 2, 3}), ElementsAre(12.5F, 23.5F, 30.5F));
}

TEST(Network, EveryOtherOperationIsAsDefined) {
  for (const int stride : {1, 2}) {
    TinyNetwork depthwise;
    const int in = depthwise.input({1, 6, 7, 4});
    tflite::DepthwiseConv2DOptionsT options;
    options.stride_h = options.stride_w = stride;
    options.depth_multiplier = 1;
    options.activation = Activation::RELU6;
    const int weights = depthwise.floats({1, 3, 3, 4}, random_numbers(36, 3));
    depthwise.output(depthwise.node(BuiltinOperator::DEPTHWISE_CONV_2D,
                                    {in, weights, depthwise.floats({4}, random_numbers(4, 4))},
                                    {1, (6 + stride - 1) / stride, (7 + stride - 1) / stride, 4}, options));
    expect_as_defined(depthwise);
  }
  {
    TinyNetwork sum;
    const int in = sum.input({1, 3, 4, 2});
    tflite::AddOptionsT options;
    options.activation = Activation::RELU;
    const int s = sum.node(BuiltinOperator::LOGISTIC, {in}, {1, 3, 4, 2});
    sum.output(sum.node(BuiltinOperator::ADD, {in, s}, {1, 3, 4, 2}, options));
    expect_as_defined(sum);
  }
  {
    TinyNetwork pooled;
    const int in = pooled.input({1, 6, 8, 3});
    tflite::Pool2DOptionsT options;
    options.filter_height = options.filter_width = 2;
    options.stride_h = options.stride_w = 2;
    pooled.output(pooled.node(BuiltinOperator::MAX_POOL_2D, {in}, {1, 3, 4, 3}, options));
    expect_as_defined(pooled);
  }
  {
    TinyNetwork padded;
    const int in = padded.input({1, 3, 4, 2});
    const int more =
        padded.node(BuiltinOperator::PAD, {in, padded.ints({4, 2}, {0, 0, 1, 2, 3, 0, 0, 0})}, {1, 6, 7, 2});
    const int weights = padded.floats({3, 2, 2, 2}, random_numbers(24, 5));
    padded.output(padded.node(BuiltinOperator::CONV_2D, {more, weights, padded.floats({3}, {1, 2, 3})}, {1, 5, 6, 3},
                              convolution(Padding::VALID, 1)));
    expect_as_defined(padded);
  }
  {
    TinyNetwork spread;
    const int in = spread.input({1, 2, 3, 8});
    spread.output(spread.node(BuiltinOperator::DEPTH_TO_SPACE, {in}, {1, 4, 6, 2}));
    expect_as_defined(spread);
  }
  {
    TinyNetwork clamped;
    const int in = clamped.input({1, 2, 3, 2});
    clamped.output(clamped.node(BuiltinOperator::RELU, {in}, {1, 2, 3, 2}));
    expect_as_defined(clamped);
  }
}

TinyNetwork resizing(bool corners, bool half_pixel) {
  TinyNetwork tiny;
  const int in = tiny.input({1, 3, 4, 2});
  tflite::ResizeBilinearOptionsT options;
  options.align_corners = corners;
  options.half_pixel_centers = half_pixel;
  tiny.output(tiny.node(BuiltinOperator::RESIZE_BILINEAR, {in, tiny.ints({2}, {6, 8})}, {1, 6, 8, 2}, options));
  return tiny;
}

TEST(Network, ResizesByPixelsThatAreSquares) {
  expect_as_defined(resizing(false, true));
  EXPECT_THROW((void)read_tflite(resizing(false, false).file()), Error);
  EXPECT_THROW((void)read_tflite(resizing(true, false).file()), Error);
}

TEST(Network, ResultsThatAreJoinedFollowEachOther) {
  TinyNetwork tiny;
  const int in = tiny.input({1, 2, 3, 2});
  const int flat = tiny.node(BuiltinOperator::RESHAPE, {in}, {1, 6, 2});
  const int positive = tiny.node(BuiltinOperator::RELU, {in}, {1, 2, 3, 2});
  const int other = tiny.node(BuiltinOperator::RESHAPE, {positive}, {1, 6, 2});
  tflite::ConcatenationOptionsT options;
  options.axis = 1;
  tiny.output(tiny.node(BuiltinOperator::CONCATENATION, {flat, other}, {1, 12, 2}, options));
  expect_as_defined(tiny);
  Network network(read_tflite(tiny.file()));
  EXPECT_THAT(network.output_shape(0), ElementsAre(1, 12, 2));
  const auto joined = run(network, {-1, 2, -3, 4, -5, 6, -7, 8, -9, 10, -11, 12});
  EXPECT_EQ(joined[0], -1);
  EXPECT_EQ(joined[12], 0);
  EXPECT_EQ(joined[13], 2);
}

TEST(TfliteReader, WeightsOfSixteenBitsAndSparseOnesBecomeWhatTheyStandFor) {
  // Of 2 x 1 x 1 x 3 weights only [0][2] = 1.5 and [1][0] = -2 are written, as halves.
  TinyNetwork tiny;
  const int in = tiny.input({1, 1, 1, 3});
  const int sparse = tiny.constant<std::uint16_t>({2, 1, 1, 3}, {0x3E00, 0xC000}, tflite::TensorType::FLOAT16);
  auto sparsity = std::make_unique<tflite::SparsityParametersT>();
  sparsity->traversal_order = {0, 1, 2, 3};
  for (const int dense : {2, 1, 1}) {
    auto level = std::make_unique<tflite::DimensionMetadataT>();
    level->dense_size = dense;
    sparsity->dim_metadata.push_back(std::move(level));
  }
  auto rows = std::make_unique<tflite::DimensionMetadataT>();
  rows->format = tflite::DimensionType::SPARSE_CSR;
  tflite::Uint8VectorT segments;
  segments.values = {0, 1, 2};
  tflite::Uint16VectorT indices;
  indices.values = {2, 0};
  rows->array_segments.Set(std::move(segments));
  rows->array_indices.Set(std::move(indices));
  sparsity->dim_metadata.push_back(std::move(rows));
  tiny.graph().tensors[std::size_t(sparse)]->sparsity = std::move(sparsity);
  const int half = tiny.node(BuiltinOperator::DENSIFY, {sparse}, {2, 1, 1, 3});
  const int weights = tiny.node(BuiltinOperator::DEQUANTIZE, {half}, {2, 1, 1, 3});
  tiny.output(tiny.node(BuiltinOperator::CONV_2D, {in, weights, tiny.floats({2}, {0, 0})}, {1, 1, 1, 2},
                        convolution(Padding::SAME, 1)));
  Network network(read_tflite(tiny.file()));
  EXPECT_THAT(run(network, {1, 10, 100}), ElementsAre(150, -2));
}

// The file that `spoil` leaves of a good one.
std::vector<std::uint8_t> spoilt(const std::function<void(TinyNetwork&)>& spoil) {
  auto tiny = convolving(6, 3, Padding::SAME, 1);
  spoil(tiny);
  return tiny.file();
}

void expect_refusal(const std::vector<std::uint8_t>& file, const std::string& words) {
  try {
    (void)read_tflite(file);
    FAIL() << "not refused: " << words;
  } catch (const Error& error) {
    EXPECT_EQ(error.fault(), Fault::kUsage);
    EXPECT_THAT(error.what(), HasSubstr(words));
    EXPECT_THAT(error.hint(), HasSubstr("@mediapipe/pose"));
  }
}

TEST(TfliteReader, RefusesWhatItDoesNotUnderstandByName) {
  ASSERT_NO_THROW((void)read_tflite(spoilt([](TinyNetwork&) {})));
  const auto refused = [](const std::function<void(TinyNetwork&)>& spoil, const std::string& words) {
    SCOPED_TRACE(words);
    expect_refusal(spoilt(spoil), words);
  };
  const auto op = [](TinyNetwork& t) -> tflite::OperatorT& { return *t.graph().operators[0]; };
  refused([](TinyNetwork& t) { t.model.operator_codes[0]->builtin_code = BuiltinOperator(99); }, "kind 99");
  refused([&](TinyNetwork& t) { op(t).options.Reset(); }, "without its settings");
  refused([&](TinyNetwork& t) { op(t).options.AsConv2DOptions()->stride_h = 0; }, "stride");
  refused([&](TinyNetwork& t) { op(t).options.AsConv2DOptions()->dilation_w_factor = 2; }, "holes");
  refused([&](TinyNetwork& t) { op(t).options.AsConv2DOptions()->activation = Activation(5); }, "activation of kind 5");
  refused([&](TinyNetwork& t) { op(t).options.AsConv2DOptions()->padding = Padding(7); }, "padding");
  refused([&](TinyNetwork& t) { op(t).inputs[1] = 77; }, "not there");
  refused([&](TinyNetwork& t) { op(t).inputs[0] = op(t).outputs[0]; }, "not computed yet");
  refused([&](TinyNetwork& t) { op(t).inputs.pop_back(); }, "odd number of inputs");
  refused([&](TinyNetwork& t) { op(t).outputs = {0}; }, "twice");
  refused([&](TinyNetwork& t) { op(t).outputs = {1, 2}; }, "several results");
  refused([&](TinyNetwork& t) { op(t).opcode_index = 8; }, "not there");
  refused([](TinyNetwork& t) { t.graph().tensors[1]->shape = {5, 3, 3, 4}; }, "another number");
  refused([](TinyNetwork& t) { t.graph().tensors[3]->shape[1] = 9; }, "another shape");
  refused([](TinyNetwork& t) { t.graph().tensors[0]->shape[1] = -6; }, "impossible size");
  refused([](TinyNetwork& t) { t.graph().tensors[0]->shape = {1, 1 << 20, 1 << 20, 3}; }, "impossible size");
  refused([](TinyNetwork& t) { t.graph().tensors[1]->type = tflite::TensorType(9); }, "type 9");
  refused([](TinyNetwork& t) { t.graph().tensors[1]->buffer = 99; }, "without a place");
  refused([](TinyNetwork& t) { t.model.buffers[1]->data.pop_back(); }, "odd length");
  refused([](TinyNetwork& t) { std::fill_n(t.model.buffers[1]->data.begin(), 4, 0xFF); }, "no numbers");
  refused([](TinyNetwork& t) { t.graph().inputs.clear(); }, "not one input");
  refused([](TinyNetwork& t) { t.graph().outputs.clear(); }, "no output");
  refused([](TinyNetwork& t) { t.graph().outputs = {1}; }, "nothing computes");
  refused([](TinyNetwork& t) { t.model.subgraphs.clear(); }, "not one graph");
  refused([](TinyNetwork& t) { t.graph().outputs.assign(17, t.graph().outputs[0]); }, "too many outputs");
  refused(
      [](TinyNetwork& t) {
        for (int k = 0; k < 3; ++k) t.tensor({1, 1 << 12, 1 << 12, 2});
      },
      "memory holds");
}

TEST(TfliteReader, RefusesWhatWouldOverflowOrNeverEnd) {
  {
    // A square of 65536 pixels a side has 2^32 of them, which is 0 in 32 bits.
    TinyNetwork tiny;
    const int in = tiny.input({1, 1, 1, 1});
    tiny.output(tiny.node(BuiltinOperator::DEPTH_TO_SPACE, {in}, {1, 65536, 1, 1}));
    expect_refusal(tiny.file(), "odd square");
  }
  {
    TinyNetwork tiny;
    const int in = tiny.input({1, 1 << 24, 1, 1});
    tflite::ConcatenationOptionsT options;
    options.axis = 1;
    const int more = tiny.node(BuiltinOperator::RELU, {in}, {1, 1 << 24, 1, 1});
    tiny.output(tiny.node(BuiltinOperator::CONCATENATION, std::vector<int>(300, more), {1, 1 << 24, 1, 1}, options));
    expect_refusal(tiny.file(), "joins more than memory holds");
  }
  {
    TinyNetwork tiny;
    const int in = tiny.input({1, 2000, 2000, 1});
    tflite::Pool2DOptionsT options;
    options.filter_height = options.filter_width = 2000;
    options.stride_h = options.stride_w = 1;
    tiny.output(tiny.node(BuiltinOperator::MAX_POOL_2D, {in}, {1, 2000, 2000, 1}, options));
    expect_refusal(tiny.file(), "waited for");
  }
  {
    TinyNetwork tiny;
    const int in = tiny.input({1, 2, 2, 1});
    tiny.output(tiny.node(BuiltinOperator::ADD, {in, tiny.floats({1, 2, 2, 1}, {1, 2, 3, 4})}, {1, 2, 2, 1}));
    expect_refusal(tiny.file(), "what is constant");
  }
  {
    TinyNetwork tiny;
    const int in = tiny.input({1, 2, 2, 1});
    tiny.output(tiny.node(BuiltinOperator::PAD, {in, tiny.ints({4, 2}, {0, 0, 1, 1, 1, 1, 0, 0})}, {1, 4, 4, 1}));
    expect_refusal(tiny.file(), "nothing computes");
  }
}

TEST(TfliteReader, ATruncatedFileIsRefusedWhereverItEnds) {
  const auto whole = spoilt([](TinyNetwork&) {});
  for (std::size_t bytes = 0; bytes < whole.size(); ++bytes) {
    try {
      // Alignment may leave bytes at the end that say nothing.
      (void)read_tflite(std::vector<std::uint8_t>(whole.begin(), whole.begin() + std::ptrdiff_t(bytes)));
      EXPECT_GE(bytes + 8, whole.size());
    } catch (const Error& error) {
      EXPECT_EQ(error.fault(), Fault::kUsage);
    }
  }
}

}  // namespace
}  // namespace choreo::vision
