// SPDX-License-Identifier: Apache-2.0
// How far the program's masks of the synthetic performer agree with what is true of it.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "devices/source_uri.hpp"
#include "devices/synthetic/synthetic_source.hpp"
#include "end_to_end/choreoscope_run.hpp"

namespace choreo::test {

struct MaskFigures {
  double mean_iou = 0;
  nlohmann::json summary;
};

/// Mean intersection over union of the program's masks with the truth, over the frames whose truth has a body.
/// Expects no body where the truth has none.
/// @param from_s  frames before are not looked at.
inline MaskFigures mask_figures(const std::string& source, const std::vector<std::string>& more = {},
                                double from_s = 0) {
  const TempFolder folder;
  std::vector<std::string> arguments{"--save", "masks", "--set", "plot.width_px=320", "--set", "plot.thumbnails=0"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  analyze_with_network(source, folder / "out", arguments);
  const auto file = read_npy(folder / "out/masks.npy");
  const int rows = static_cast<int>(file.shape.at(1));
  const int cols = static_cast<int>(file.shape.at(2));
  const auto request =
      devices::performer_request(devices::parse_source_uri(source, [](const std::string&) { return false; }));
  const devices::synthetic::Performer performer(request.script, request.settings);
  EXPECT_EQ(file.shape[0], static_cast<std::size_t>(performer.frame_count()));
  double sum = 0;
  int bodies = 0;
  for (int i = 0; i < performer.frame_count(); ++i) {
    if (i < from_s * request.settings.fps) continue;
    const auto truth_full = performer.perform(i).mask;
    cv::Mat truth;
    cv::resize(truth_full, truth, {cols, rows}, 0, 0, cv::INTER_AREA);
    truth = truth >= 128;
    const auto size = static_cast<std::size_t>(rows) * static_cast<std::size_t>(cols);
    const cv::Mat found(rows, cols, CV_8UC1,
                        const_cast<std::uint8_t*>(file.data.data() + static_cast<std::size_t>(i) * size));
    const cv::Mat mask = found != 0;
    // Less than half a percent of the picture is no body; around that, either may be right.
    const double percent = 100.0 * cv::countNonZero(truth) / double(truth.total());
    if (percent < 0.4) {
      EXPECT_EQ(cv::countNonZero(mask), 0) << "a body in the empty room, frame " << i + 1 << " of " << source;
    }
    if (percent < 0.6) continue;
    sum += double(cv::countNonZero(mask & truth)) / double(cv::countNonZero(mask | truth));
    ++bodies;
  }
  EXPECT_GT(bodies, 0) << source;
  const double mean = sum / bodies;
  std::printf("%s: mean IoU %.4f over %d frames\n", source.c_str(), mean, bodies);
  const auto summary = read_bytes(folder / "out/summary.json");
  return {mean, nlohmann::json::parse(summary.begin(), summary.end())};
}

inline double mean_iou(const std::string& source, const std::vector<std::string>& more = {}, double from_s = 0) {
  return mask_figures(source, more, from_s).mean_iou;
}

}  // namespace choreo::test
