// SPDX-License-Identifier: Apache-2.0
// Every operation of a network as its definition has it, slowly, in double precision.
#pragma once

#include <span>
#include <vector>

#include "vision/network/network_graph.hpp"

namespace choreo::test {

/// What every output is for that input.
[[nodiscard]] std::vector<std::vector<double>> evaluate(const vision::NetworkGraph& graph,
                                                        std::span<const float> input);

}  // namespace choreo::test
