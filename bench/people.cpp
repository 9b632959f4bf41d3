// SPDX-License-Identifier: Apache-2.0
// What a look of the person network takes on one core, beside OpenCV's dnn and the processor's multiplications and
// additions.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "core/error.hpp"
#include "limits.hpp"
#include "network_peer.hpp"
#include "pipeline/model_file.hpp"
#include "pipeline/person_models.hpp"
#include "report.hpp"
#include "vision/network/network.hpp"
#include "vision/network/tflite_reader.hpp"

namespace choreo::bench {
namespace {

vision::NetworkGraph graph_of(const char* file) {
  constexpr std::size_t kMost = std::size_t{64} << 20U;
  const auto path = pipeline::usual_models_folder() + "/" + file;
  const auto bytes = pipeline::bytes_of_model(path, kMost, "a network", pipeline::kPersonModelsRemedy);
  return vision::read_tflite({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
}

// Of the convolutions, a multiplication with its addition as two.
double operations_of(const vision::NetworkGraph& graph) {
  double sum = 0;
  for (const auto& node : graph.nodes) {
    const double windows =
        2.0 * node.kernel.y * node.kernel.x * double(graph.tensors[std::size_t(node.output)].count());
    if (node.operation == vision::NetworkOperation::kDepthwise) sum += windows;
    if (node.operation == vision::NetworkOperation::kConvolution) {
      sum += windows * graph.tensors[std::size_t(node.inputs[0])].shape[3];
    }
  }
  return sum;
}

// The pieces take turns, and the median counts.
std::vector<double> medians(int repetitions, const std::vector<std::function<void()>>& work) {
  std::vector<std::vector<double>> times(work.size());
  for (int turn = -1; turn < repetitions; ++turn) {
    for (std::size_t k = 0; k < work.size(); ++k) {
      const auto begin = std::chrono::steady_clock::now();
      work[k]();
      const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
      if (turn >= 0) times[k].push_back(took.count());
    }
  }
  std::vector<double> out;
  for (auto& t : times) {
    std::ranges::nth_element(t, t.begin() + std::ptrdiff_t(t.size() / 2));
    out.push_back(t[t.size() / 2]);
  }
  return out;
}

std::string in_ms(double seconds) { return fmt::format("{:.1f} ms", 1e3 * seconds); }

void add(const char* name, const char* file, bool has_peer, const Settings& settings, Report& report) {
  const auto graph = graph_of(file);
  vision::Network network(graph);
  const auto& shape = network.input_shape();
  const int sizes[] = {1, shape[3], shape[1], shape[2]};
  cv::Mat picture(4, sizes, CV_32F);
  cv::RNG(1).fill(picture, cv::RNG::UNIFORM, 0, 1);
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t p = 0; p < network.input().size() / 3; ++p) {
      network.input()[3 * p + c] = picture.ptr<float>()[c * (network.input().size() / 3) + p];
    }
  }
  std::vector<std::function<void()>> work = {[&] { network.run(); }};
  std::optional<PeerNetwork> peer;
  std::vector<cv::Mat> given;
  if (has_peer) {
    peer.emplace(graph);
    work.emplace_back([&] {
      cv::setNumThreads(1);
      peer->net.setInput(picture);
      peer->net.forward(given, peer->outputs);
      cv::setNumThreads(0);
    });
  }
  const auto times = medians(settings.smoke ? 1 : settings.quick ? 15 : 60, work);
  const double limit = operations_of(graph) / multiply_add_rate();
  const double ours = times[0];
  const double theirs = has_peer ? times[1] : 0;
  report.lines.push_back({name, has_peer ? in_ms(theirs) : "", in_ms(ours), in_ms(limit),
                          has_peer ? fmt::format("{:.1f} x", theirs / ours) : "",
                          fmt::format("{:.0f} %", 100 * limit / ours)});
  report.figures[fmt::format("people_{}_ms", name)] = 1e3 * ours;
  if (!has_peer) return;
  report.figures[fmt::format("people_{}_vs_opencv", name)] = theirs / ours;
  // Of the joints, the first output; both read the same file.
  double apart = 0;
  for (std::size_t k = 0; k < network.output(0).size(); ++k) {
    apart = std::max(apart, std::abs(double(network.output(0)[k]) - double(given[0].ptr<float>()[k])));
  }
  report.lines.push_back(
      {fmt::format("{}, largest difference of a joint's numbers", name), "", fmt::format("{:.2g}", apart), "", "", ""});
}

}  // namespace

void people(const Settings& settings, Report& report) {
  for (const bool quick : {true, false}) {
    const auto missing = pipeline::missing_person_models({"", quick});
    if (missing.empty()) continue;
    report.notes.push_back("nothing was measured: there is no " + missing);
    return;
  }
  report.notes.emplace_back("peer: OpenCV's dnn with the same weights; limit: the convolutions' multiplications and");
  report.notes.emplace_back("additions at the rate of a loop that does nothing else, in registers");
  add("lite", "pose_landmark_lite.tflite", true, settings, report);
  add("full", "pose_landmark_full.tflite", true, settings, report);
  add("detector", "pose_detection.tflite", false, settings, report);
}

}  // namespace choreo::bench
