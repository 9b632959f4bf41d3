// SPDX-License-Identifier: Apache-2.0
// Masks of what differs from the background, beside OpenCV's MOG2 and KNN, out of doors where leaves move.
#include <algorithm>
#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/background_segm.hpp>

#include "report.hpp"
#include "support/outdoors.hpp"
#include "vision/background_estimate.hpp"
#include "vision/body_masker.hpp"
#include "vision/quiet_stretches.hpp"

namespace choreo::bench {
namespace {

struct Result {
  double f = 0;
  double ms = 0;  // A picture, learning left out.
};

double ms_since(std::chrono::steady_clock::time_point begin, std::size_t pictures) {
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
  return took.count() / double(pictures);
}

// The second time round, when it has seen everything as ours has; the median of 5 pixels that is usual behind it, or
// not, whichever is better.
Result peer(const cv::Ptr<cv::BackgroundSubtractor>& subtractor, const test::Scene& scene) {
  cv::Mat found;
  for (const auto& picture : scene.pictures) subtractor->apply(picture, found);
  std::vector<cv::Mat> masks, smooth;
  const auto begin = std::chrono::steady_clock::now();
  for (const auto& picture : scene.pictures) {
    subtractor->apply(picture, found);
    masks.emplace_back(found == 255);  // 127 is a shadow.
  }
  const double ms = ms_since(begin, scene.pictures.size());
  for (const auto& mask : masks) cv::medianBlur(mask, smooth.emplace_back(), 5);
  return {std::max(test::f_measure(masks, scene.truths), test::f_measure(smooth, scene.truths)), ms};
}

Result ours(const test::Scene& scene) {
  vision::QuietStretches quiet;
  const auto seconds = [](std::size_t k) { return double(k) / test::kOutdoorsFps; };
  for (std::size_t k = 0; k < scene.pictures.size(); ++k) quiet.add(scene.pictures[k], seconds(k));
  vision::BodyMasker masker(vision::estimate_background(scene.pictures, quiet.finish()), {});
  std::vector<cv::Mat> masks;
  const auto begin = std::chrono::steady_clock::now();
  for (std::size_t k = 0; k < scene.pictures.size(); ++k) {
    masks.push_back(masker.process(scene.pictures[k], seconds(k)).mask);
  }
  return {test::f_measure(masks, scene.truths), ms_since(begin, scene.pictures.size())};
}

}  // namespace

void background(const Settings& settings, Report& report) {
  report.notes.emplace_back(
      "F, 2 TP / (2 TP + FP + FN), of drawn scenes of 160 x 120; in brackets the time of a picture");
  report.notes.emplace_back("peers: cv::BackgroundSubtractorMOG2 and KNN as they are, on their second pass");
  const double length = settings.smoke ? 7 : settings.quick ? 10 : 20;  // Seconds.
  std::vector<std::pair<std::string, test::Scene>> scenes;
  for (const double sway : {1.0, 2.0, 3.0, 5.0}) {
    scenes.emplace_back(fmt::format("leaves that sway by {:.0f} px", sway), test::garden(sway, length));
  }
  scenes.emplace_back("cars on a road", test::road(length));
  const auto cell = [](const Result& result) { return fmt::format("{:.3f} ({:.2f} ms)", result.f, result.ms); };
  for (const auto& [name, scene] : scenes) {
    const auto own = ours(scene);
    const auto mog2 = peer(cv::createBackgroundSubtractorMOG2(), scene);
    const auto knn = peer(cv::createBackgroundSubtractorKNN(), scene);
    report.lines.push_back({name + ", MOG2", cell(mog2), cell(own), "1", fmt::format("{:.2f} x", own.f / mog2.f), ""});
    report.lines.push_back({name + ", KNN", cell(knn), "", "", fmt::format("{:.2f} x", own.f / knn.f), ""});
    auto& figure = report.figures["background_" + name];
    figure = {{"ours", own.f}, {"mog2", mog2.f}, {"knn", knn.f}};
  }
}

}  // namespace choreo::bench
