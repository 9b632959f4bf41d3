// SPDX-License-Identifier: Apache-2.0
// Reads what the MediaPipe pose models use of TensorFlow Lite.
#pragma once

#include <cstdint>
#include <span>

#include "vision/network/network_graph.hpp"

namespace choreo::vision {

/// The first graph of a TensorFlow Lite file.
///
/// Weights of 16 bits become 32, sparse ones dense, activations the limits of their operation. Operations that only
/// change how a constant is written are done here.
/// @throws Error (usage) where the file is damaged or asks for what is not understood, naming it.
[[nodiscard]] NetworkGraph read_tflite(std::span<const std::uint8_t> file);

}  // namespace choreo::vision
