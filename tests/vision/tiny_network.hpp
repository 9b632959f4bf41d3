// SPDX-License-Identifier: Apache-2.0
// Writes TensorFlow Lite files of a few operations.
#pragma once

#include <cstdint>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include <tflite_generated.h>

namespace choreo::test {

/// A file under construction; `model` may be spoilt before it is written.
class TinyNetwork {
 public:
  TinyNetwork() {
    model.version = 3;
    model.subgraphs.push_back(std::make_unique<tflite::SubGraphT>());
    model.buffers.push_back(std::make_unique<tflite::BufferT>());  // The first is empty by convention.
  }

  tflite::SubGraphT& graph() { return *model.subgraphs[0]; }

  /// A tensor that is computed or given. @return its number.
  int tensor(std::vector<int> shape, std::uint32_t buffer = 0, tflite::TensorType type = tflite::TensorType::FLOAT32) {
    auto t = std::make_unique<tflite::TensorT>();
    t->shape = std::move(shape);
    t->type = type;
    t->buffer = buffer;
    graph().tensors.push_back(std::move(t));
    return int(graph().tensors.size()) - 1;
  }
  int input(std::vector<int> shape) {
    graph().inputs.push_back(tensor(std::move(shape)));
    return graph().inputs.back();
  }
  template <typename T>
  int constant(std::vector<int> shape, const std::vector<T>& numbers, tflite::TensorType type) {
    auto buffer = std::make_unique<tflite::BufferT>();
    buffer->data.resize(numbers.size() * sizeof(T));
    std::memcpy(buffer->data.data(), numbers.data(), buffer->data.size());
    model.buffers.push_back(std::move(buffer));
    return tensor(std::move(shape), std::uint32_t(model.buffers.size() - 1), type);
  }
  int floats(std::vector<int> shape, const std::vector<float>& numbers) {
    return constant(std::move(shape), numbers, tflite::TensorType::FLOAT32);
  }
  int ints(std::vector<int> shape, const std::vector<std::int32_t>& numbers) {
    return constant(std::move(shape), numbers, tflite::TensorType::INT32);
  }

  /// An operation. @return the number of its output.
  int node(tflite::BuiltinOperator code, std::vector<int> inputs, std::vector<int> shape) {
    auto c = std::make_unique<tflite::OperatorCodeT>();
    c->builtin_code = code;
    model.operator_codes.push_back(std::move(c));
    auto op = std::make_unique<tflite::OperatorT>();
    op->opcode_index = std::uint32_t(model.operator_codes.size() - 1);
    op->inputs = std::move(inputs);
    op->outputs = {tensor(std::move(shape))};
    graph().operators.push_back(std::move(op));
    return graph().operators.back()->outputs[0];
  }
  template <typename Options>
  int node(tflite::BuiltinOperator code, std::vector<int> inputs, std::vector<int> shape, Options options) {
    const int out = node(code, std::move(inputs), std::move(shape));
    graph().operators.back()->options.Set(std::move(options));
    return out;
  }
  void output(int tensor) { graph().outputs.push_back(tensor); }

  [[nodiscard]] std::vector<std::uint8_t> file() const {
    flatbuffers::FlatBufferBuilder builder;
    tflite::FinishModelBuffer(builder, tflite::Model::Pack(builder, &model));
    return {builder.GetBufferPointer(), builder.GetBufferPointer() + builder.GetSize()};
  }

  tflite::ModelT model;
};

}  // namespace choreo::test
