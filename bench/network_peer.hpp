// SPDX-License-Identifier: Apache-2.0
// The same network in OpenCV's dnn module: the peer of the benchmark `people`.
#pragma once

#include <opencv2/dnn.hpp>

#include "vision/network/network_graph.hpp"

namespace choreo::bench {

/// @param graph  of a pose landmark model; what others have (kDepthToSpace, several parts in one output) is not known.
/// @return the network, and the names of its outputs.
struct PeerNetwork {
  explicit PeerNetwork(const vision::NetworkGraph& graph);

  cv::dnn::Net net;
  std::vector<cv::String> outputs;
};

}  // namespace choreo::bench
