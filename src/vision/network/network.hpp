// SPDX-License-Identifier: Apache-2.0
// Runs a convolutional network.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "vision/network/network_graph.hpp"

namespace choreo::vision {

/// A network that is ready to run. oneDNN computes, on the caller's thread alone.
/// @thread thread-bound; several may run in threads of their own.
class Network {
 public:
  /// @throws Error (failure) where memory is short.
  explicit Network(const NetworkGraph& graph);
  ~Network();
  Network(Network&&) noexcept;
  Network& operator=(Network&&) noexcept;

  /// 1, height, width, channels.
  [[nodiscard]] const std::vector<int>& input_shape() const;
  /// To be filled before `run`.
  [[nodiscard]] std::span<float> input();

  /// @throws Error (failure) where oneDNN gives up.
  void run();

  [[nodiscard]] std::size_t outputs() const;
  [[nodiscard]] const std::vector<int>& output_shape(std::size_t k) const;
  /// What the last run gave; another run writes over it.
  [[nodiscard]] std::span<const float> output(std::size_t k) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace choreo::vision
